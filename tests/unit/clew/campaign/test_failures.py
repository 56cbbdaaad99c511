import pytest

from clew.campaign.episode import CRASHED, OUT_OF_TIME, Surprise
from clew.campaign.failures import failure_told
from tests.support.campaigns import outcome


@pytest.mark.parametrize(
    ("told", "again"),
    [
        (
            "there was a way, and the run ended before r3, r4 arrived: the time was up",
            "there was a way, and the run ended before r2 arrived: the time was up",
        ),
        (
            "all faults were over at t=9.2 s, and there was one strand at t=80.0 s",
            "all faults were over at t=12 s, and there was one strand at t=77.31 s",
        ),
    ],
)
def test_a_sentence_is_the_same_but_for_its_numbers_and_robots(told: str, again: str) -> None:
    ways = [failure_told(outcome(surprise=Surprise.UNLIVELY, reason=reason)) for reason in (told, again)]
    assert ways[0] is not None
    assert ways[1] is not None
    assert ways[0].way == ways[1].way


def test_not_to_heal_in_time_is_not_the_same_as_not_to_arrive() -> None:
    late = "all faults were over at t=9.2 s, and there was one strand at t=80.0 s"
    away = "there was a way, and the run ended before r3 arrived: the time was up"
    one, other = (failure_told(outcome(surprise=Surprise.UNLIVELY, reason=said)) for said in (late, away))
    assert one is not None
    assert other is not None
    assert one.way != other.way


@pytest.mark.parametrize(
    ("surprise", "ending", "reason", "broken", "way"),
    [
        (
            Surprise.VIOLATION,
            "",
            "S2 broken by robot 3 and robot 1 at t=4.0 s: x",
            {"S2": 1, "P1": 3},
            "breaks S2",
        ),
        (Surprise.VIOLATION, "", "robot 2 died at t=1.0 s", {"S2": 0, "P4": 1}, "breaks P4"),
        (Surprise.CRASHED, "", "a robot failed: KeyError: 3 (strand.py:7)", {}, "raises KeyError"),
        (Surprise.CRASHED, CRASHED, "ValueError: no (world.py:9)", {}, "raises ValueError"),
        (Surprise.CRASHED, OUT_OF_TIME, "the wall-clock limit struck", {}, "has no end"),
    ],
)
def test_the_way_is_the_invariant_the_exception_or_that_there_is_no_end(
    surprise: Surprise, ending: str, reason: str, broken: dict[str, int], way: str
) -> None:
    failure = failure_told(
        outcome(surprise=surprise, ending=ending, reason=reason, violations_by_invariant=broken)
    )
    assert failure is not None
    assert failure.way == way


def test_what_does_not_surprise_did_not_fail() -> None:
    assert failure_told(outcome(ok=False, reason="the time was up")) is None
