from dataclasses import dataclass, field

import numpy as np

from clew.explore.store import Numbers, Snapshots
from protocol.arrays import Floats


@dataclass
class Core:
    constant: object
    heard: list[tuple[float, float]] = field(default_factory=list)
    seen: Floats = field(default_factory=lambda: np.zeros(3))


class Large:
    def __reduce__(self) -> str:
        raise AssertionError("a constant is not copied")


def test_equal_contents_have_equal_numbers() -> None:
    constant = Large()
    kept = Snapshots[Core]((constant,), Numbers())
    one, other = (Core(constant, [(0.1 + 0.2, 1.0)]) for _ in range(2))
    assert kept.add(one) == kept.add(other)
    assert len(kept) == 1


def test_contents_that_differ_in_one_bit_have_different_numbers() -> None:
    kept = Snapshots[Core]((), Numbers())
    seen = np.zeros(3)
    seen[1] = np.nextafter(0.0, 1.0)
    cores = [Core(None), Core(None, seen=seen), Core(None, [(0.3, 1.0)]), Core(None, [(0.1 + 0.2, 1.0)])]
    assert len({kept.add(core) for core in cores}) == len(cores)


def test_a_loaded_object_may_be_changed_without_changing_what_is_kept() -> None:
    constant = Large()
    kept = Snapshots[Core]((constant,), Numbers())
    number = kept.add(Core(constant))
    copy = kept.load(number)
    copy.heard.append((1.0, 2.0))
    copy.seen[0] = 7.0
    again = kept.load(number)
    assert (again.heard, again.seen[0], again.constant) == ([], 0.0, constant)
    assert kept.add(copy) != number
    assert kept.add(again) == number


def test_values_have_numbers_and_numbers_values() -> None:
    numbers = Numbers[str]()
    assert [numbers.add(each) for each in ("a", "b", "a")] == [0, 1, 0]
    assert [numbers[number] for number in range(len(numbers))] == ["a", "b"]
