import pytest

from clew.campaign.episode import CRASHED, OUT_OF_TIME, Surprise
from clew.campaign.failures import failure_of_outcome
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
        (
            "the time was up with 0 of 5 living robots arrived: nothing had moved since t=4 s",
            "the time was up with 0 of 1 living robots arrived: r1 was driving step 8",
        ),
        (
            "by t=69.2 s nothing had moved for long: r1 had found no step after step 1 since t=6.5 s",
            "by t=81.7 s nothing had moved for long: no step had been planned",
        ),
    ],
)
def test_sentences_that_differ_only_in_what_does_not_matter_are_the_same_way_to_fail(
    told: str, again: str
) -> None:
    ways = [
        failure_of_outcome(outcome(surprise=Surprise.LIVENESS, reason=reason)) for reason in (told, again)
    ]
    assert ways[0] is not None
    assert ways[1] is not None
    assert ways[0].way == ways[1].way


def test_healing_late_and_not_arriving_are_different_ways_to_fail() -> None:
    late = "all faults were over at t=9.2 s, and there was one strand at t=80.0 s"
    away = "there was a way, and the run ended before r3 arrived: the time was up"
    one, other = (
        failure_of_outcome(outcome(surprise=Surprise.LIVENESS, reason=said)) for said in (late, away)
    )
    assert one is not None
    assert other is not None
    assert one.way != other.way


@pytest.mark.parametrize(
    ("surprise", "ending", "reason", "broken", "way"),
    [
        (
            Surprise.VIOLATION,
            "",
            "S2 (separation) broken by robot 3 and robot 1 at t=4.0 s: x",
            {"S2": 1, "P1": 3},
            "breaks S2 (separation)",
        ),
        (Surprise.VIOLATION, "", "robot 2 died at t=1.0 s", {"S2": 0, "P4": 1}, "breaks P4 (nothing stale)"),
        (Surprise.CRASHED, "", "a robot failed: KeyError: 3 (strand.py:7)", {}, "raises KeyError"),
        (Surprise.CRASHED, CRASHED, "ValueError: no (world.py:9)", {}, "raises ValueError"),
        (Surprise.STOPPED, OUT_OF_TIME, "the wall-clock limit struck", {}, "has no end"),
    ],
)
def test_the_way_to_fail_is_the_invariant_the_exception_or_having_no_end(
    surprise: Surprise, ending: str, reason: str, broken: dict[str, int], way: str
) -> None:
    failure = failure_of_outcome(
        outcome(surprise=surprise, ending=ending, reason=reason, violations_by_invariant=broken)
    )
    assert failure is not None
    assert failure.way == way


def test_an_outcome_without_surprise_did_not_fail() -> None:
    assert failure_of_outcome(outcome(ok=False, reason="the time was up")) is None
