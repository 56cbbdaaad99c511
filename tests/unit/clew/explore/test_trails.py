from dataclasses import dataclass, field

import pytest

from clew.explore import trails
from clew.explore.store import Numbers, Snapshots
from clew.explore.trails import Trails


@dataclass
class Core:
    heard: list[int] = field(default_factory=list)

    def hear(self, number: int) -> None:
        self.heard.append(number)
        self.heard.sort()


def begun() -> Trails[Core, int]:
    return Trails(Snapshots((), Numbers()), Core.hear)


def after(kept: Trails[Core, int], number: int, *events: int) -> int:
    for event in events:
        core = kept.load(number)
        core.hear(event)
        number = kept.follow(number, event, core)
    return number


def test_objects_are_compared_only_when_they_are_settled() -> None:
    kept = begun()
    start = kept.add(Core())
    one, other = after(kept, start, 1, 2), after(kept, start, 2, 1)
    assert one != other
    assert kept.settle(one) == kept.settle(other) == kept.add(Core([1, 2]))
    assert kept.settle(kept.settle(one)) == kept.settle(one)


@pytest.mark.parametrize("at_hand", [0, 2000])
def test_what_is_not_kept_is_computed_again_from_the_content_before_it(
    at_hand: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trails, "AT_HAND_MAX", at_hand)
    kept = begun()
    number = after(kept, kept.add(Core()), 3, 1, 2)
    assert [kept.load(number).heard for _ in range(2)] == [[1, 2, 3]] * 2


def test_what_goes_on_from_a_kept_object_is_kept_and_others_are_forgotten() -> None:
    kept = begun()
    start, other = kept.add(Core()), kept.add(Core([9]))
    number = after(kept, start, 1, 2)
    settled = kept.settle(after(kept, start, 7))
    kept.keep_only([number, settled])
    assert (kept.load(number).heard, kept.load(settled).heard) == ([1, 2], [7])
    with pytest.raises(KeyError):
        kept.load(other)
    assert len(kept) == 4  # two contents, two events
    assert kept.add(Core([9])) != other  # no number comes again
