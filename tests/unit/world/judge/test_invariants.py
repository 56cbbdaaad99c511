"""P1, P2, P4 to P6, and F2 and F5 by what robots record: each is kept, and each is seen broken."""

import pytest

from protocol.timeline import (
    Entry,
    LeaderSucceeded,
    RobotDied,
    RobotFailed,
    RobotStarted,
    StrandHealed,
    TrafficCounted,
    ViewJoined,
    ViewLeft,
)
from protocol.timeline.invariants import INVARIANTS
from tests.support.histories.entries import Said
from tests.support.histories.fenced import EXACT, FIRST, SECOND, broken, grant, plan, run
from world.judge.judgement import Court

NEVER = 30_001
"""An epoch that no fence of the run has."""


def counted(*, overflowed: int = 0, unrecorded: int = 0) -> TrafficCounted:
    return TrafficCounted(
        sent={}, received={}, newest={}, refused={}, overflowed=overflowed, unrecorded=unrecorded
    )


def test_a_lawful_run_violates_nothing() -> None:
    assert broken(run()) == []


BREACHES: dict[str, tuple[list[str], Said]] = {
    "a follower plans a step": (["P1"], (5.1, "r2", plan(2.0, epoch=SECOND))),
    "a follower says that it leads": (["P1"], (5.1, "r2", LeaderSucceeded(epoch=SECOND, before=1))),
    "a follower says that its strand has healed": (
        ["P1"],
        (5.1, "r2", StrandHealed(epoch=SECOND, robots=1)),
    ),
    "back to an older view": (["P2"], (5.1, "r1", ViewJoined(epoch=FIRST))),
    "back aside": (["P2"], (5.1, "r1", ViewLeft(epoch=FIRST))),
    "an older step": (["P2"], (5.1, "r1", plan(1.0, step=2))),
    "an older grant": (["P2"], (5.1, "r1", grant(1.1))),
    "a view before its epoch": (["P4"], (3.9, "r2", ViewJoined(epoch=SECOND))),
    "a view that never was": (["P4"], (5.1, "r2", ViewJoined(epoch=NEVER))),
    "left out of a view that never was": (["P4"], (5.1, "r4", ViewLeft(epoch=NEVER))),
    "a step in an epoch that never was": (["F2"], (5.1, "r1", plan(1.0, epoch=NEVER))),
    "a step in a later epoch": (["F2"], (3.9, "r2", plan(1.0, epoch=SECOND, joins=True))),
    "a grant in an epoch that never was": (["F2", "F5"], (5.1, "r1", grant(1.0, epoch=NEVER))),
    "a grant before ALL": (["F5"], (1.95, "r1", grant(0.8))),
    "a grant in an epoch without ALL": (["F2", "F5", "P2"], (0.35, "r1", grant(0.8, epoch=SECOND))),
    "a grant to the robot ahead": (["F5"], (5.1, "r2", grant(2.0, to=1, epoch=SECOND))),
    "a grant to the last but one": (["F5"], (5.1, "r1", grant(1.0, to=3, epoch=SECOND))),
    "a grant to no member": (["F5"], (5.1, "r3", grant(1.0, to=4, epoch=SECOND))),
    "a grant of no member": (["F5"], (5.1, "r4", grant(1.0, to=1, epoch=SECOND))),
    "a grant that shrinks": (["F5"], (3.0, "r1", grant(0.9))),
    "an inbox that overflowed": (["P5"], (9.1, "r3", counted(overflowed=1))),
    "an outbox that overflowed": (["P5"], (9.1, "r3", counted(unrecorded=1))),
    "a core that failed": (["P6"], (9.1, "r3", RobotFailed(reason="AssertionError: nobody ahead"))),
}


@pytest.mark.parametrize(("invariants", "said"), BREACHES.values(), ids=BREACHES.keys())
def test_unlawful_entries_are_found(invariants: list[str], said: Said) -> None:
    assert broken(run(said)) == invariants


LAWFUL: dict[str, Said] = {
    "a grant that grows": (3.0, "r1", grant(1.1)),
    "a grant of less in the next epoch": (4.6, "r1", grant(0.5, epoch=SECOND)),
    "a grant to the robot right behind": (4.6, "r2", grant(0.5, to=3, epoch=SECOND)),
    "the leader says that it leads": (4.6, "r1", LeaderSucceeded(epoch=SECOND, before=None)),
    "a robot that is left out says so": (4.6, "r4", ViewLeft(epoch=SECOND)),
    "an inbox that held all": (9.1, "r3", counted()),
}


@pytest.mark.parametrize("said", LAWFUL.values(), ids=LAWFUL.keys())
def test_lawful_entries_are_no_violations(said: Said) -> None:
    assert broken(run(said)) == []


def test_a_new_process_may_begin_with_the_epoch_of_the_one_before() -> None:
    again: list[Said] = [(5.1, "r2", RobotStarted(pid=7)), (5.2, "r2", ViewLeft(epoch=FIRST))]
    assert broken(run(*again)) == []


def test_a_missing_entry_is_found_and_a_restarted_process_counts_from_one() -> None:
    court = Court(EXACT, followers_sense=True)
    for n in (1, 2, 1, 2, 4):
        court.hear("r2", Entry(n=n, t_s=1.0, hlc="", record=RobotStarted(pid=1)))
    assert [(breach.broken.invariant, breach.broken.why) for breach in court.breaches] == [
        ("P5", "its entries go on with number 4")
    ]


def test_time_that_goes_back_in_what_the_world_records_is_found() -> None:
    """As where a world resumes before its newest entry: bodies would be judged where they were before."""
    court = Court(EXACT, followers_sense=True)
    for n, (source, t_s) in enumerate([("world", 4.0), ("r1", 3.0), ("world", 4.0), ("world", 3.9)], start=1):
        court.hear(source, Entry(n=n, t_s=t_s, hlc="", record=RobotDied(robot=2, silent_since_s=1.0)))
    assert [(each.broken.invariant, each.broken.why) for each in court.breaches if each.t_s == 3.9] == [
        ("P2", "the world's time goes back from 4.000 s")
    ]


def test_identical_violations_count_once() -> None:
    wrong = grant(1.0, to=3, epoch=SECOND)
    assert broken(run((5.1, "r1", wrong), (5.2, "r1", wrong))) == ["F5"]


def test_every_invariant_has_its_place_in_the_verdict() -> None:
    assert tuple(sorted(INVARIANTS, key=lambda name: "SFPA".index(name[0]))) == INVARIANTS
    assert len(set(INVARIANTS)) == 19
