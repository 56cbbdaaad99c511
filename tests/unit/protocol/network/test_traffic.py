"""Counts of messages by key, and how they are told."""

from functools import reduce

from protocol.frames import ROBOTS_MAX
from protocol.network.outbox import Outbox
from protocol.network.traffic import OTHERS, REFUSED_KEYS_MAX, Traffic, in_parts, joined
from protocol.timeline import TrafficCounted


def test_a_removed_message_has_arrived_but_was_not_received() -> None:
    traffic = Traffic()
    traffic.receive("a", 1)
    traffic.count_removed("a", 3, "drop")
    traffic.count_removed("b", 1, "drop")
    traffic.count_removed("a", 2, "corrupt")
    assert (traffic.received, traffic.newest) == ({"a": 1}, {"a": 3, "b": 1})
    assert traffic.injected_by_fault() == {"corrupt": {"a": 1}, "drop": {"a": 1, "b": 1}}


def test_the_counts_of_refused_keys_stay_bounded_for_any_number_of_invented_keys() -> None:
    traffic = Traffic()
    for number in range(3 * REFUSED_KEYS_MAX):
        traffic.refuse(f"forged/{number}")
    traffic.refuse("forged/0")
    assert len(traffic.refused) == REFUSED_KEYS_MAX + 1
    assert (traffic.refused["forged/0"], traffic.refused[OTHERS]) == (2, 2 * REFUSED_KEYS_MAX)


def counted(robots: int) -> TrafficCounted:
    """What a robot counts that has coordinated a view of so many."""
    others = range(2, robots + 1)
    heard = {f"view/r{other}/r1": 1000 + other for other in others}
    return TrafficCounted(
        sent={f"view/r1/r{other}": 2000 + other for other in others} | {"body/r1/drive": 90_000},
        received=heard,
        newest=heard,
        injected={"drop": {f"view/r{other}/r1": 7 for other in others}, "corrupt": {"view/r2/r1": 1}},
        refused={"body/r1/odometry": 3},
        overflowed=5,
        unrecorded=2,
    )


def test_the_counts_of_a_small_fleet_are_told_as_they_are() -> None:
    assert in_parts(counted(200)) == [counted(200)]


def test_the_counts_of_the_largest_fleet_are_told_in_parts_that_fit_and_together_are_the_same() -> None:
    parts, outbox = in_parts(counted(ROBOTS_MAX)), Outbox()
    for part in parts:
        outbox.add(part, t_s=1e9, hlc="h" * 80)
    assert (len(outbox), outbox.lost_count) == (len(parts), 0)
    assert len(parts) > 1
    assert reduce(joined, parts) == counted(ROBOTS_MAX)
