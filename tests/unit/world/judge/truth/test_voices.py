"""P1 and P7: an entry counts only from the source that it concerns."""

import pytest
from msgspec.structs import replace

from protocol.timeline import (
    FaultInjected,
    GoalReached,
    LeaderSucceeded,
    PromiseBroken,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotStarted,
    RobotStranded,
    RouteLost,
    RouterFound,
    RouterLost,
    StrandHealed,
    ViewJoined,
)
from tests.support.histories.arriving import EPOCH, NEXT, broken, formation, pose, run
from tests.support.histories.entries import Said, lines_of
from world.judge.tally import Tally
from world.judge.truth.voices import Voices

LOST = RouteLost(reason="I know no way")
REACHED = GoalReached(x_m=1.0, y_m=0.0)
KILLED_2 = FaultInjected(fault="kill", rule="mine", process="r2")

FOREIGN: dict[str, tuple[str, str, Record]] = {
    "a follower that has lost the route": ("P1", "r2", LOST),
    "a follower at the goal": ("P1", "r3", REACHED),
    "one that never joined": ("P1", "r4", LOST),
    "one that never joined, and has arrived": ("P7", "r4", RobotArrived(progress_m=1.0)),
    "a pose": ("P7", "r1", pose(2, 0.0)),
    "a death": ("P7", "r1", RobotDied(robot=2, silent_since_s=0.0)),
    "a broken promise": ("P7", "r1", PromiseBroken(invariant="S1", robot=2, why="near")),
    "a fault of another process": ("P7", "r1", KILLED_2),
    "one stranded by another than the coordinator": (
        "P7",
        "r2",
        RobotStranded(epoch=EPOCH, robot=3, reason="no way"),
    ),
}


@pytest.mark.parametrize(("invariant", "source", "record"), FOREIGN.values(), ids=FOREIGN.keys())
def test_entries_that_do_not_concern_their_source_are_violations(
    invariant: str, source: str, record: Record
) -> None:
    assert broken(run((8.0, source, record))) == [(invariant, int(source[1:]))]


OWN: dict[str, tuple[str, Record]] = {
    "the leader has lost the route": ("r1", LOST),
    "its own fault": ("r2", KILLED_2),
    "a fault of a message": ("r2", FaultInjected(fault="drop", rule="loss", key="link/r1/r2", number=3)),
    "the world's fault": ("world", KILLED_2),
    "stranded by its coordinator": ("r1", RobotStranded(epoch=EPOCH, robot=3, reason="no way")),
    "the leader says so": ("r1", StrandHealed(epoch=EPOCH, robots=3)),
}


@pytest.mark.parametrize(("source", "record"), OWN.values(), ids=OWN.keys())
def test_entries_that_concern_their_source_are_none(source: str, record: Record) -> None:
    assert broken(run((8.0, source, record))) == []


def test_a_leader_that_has_left_its_strand_leads_nobody() -> None:
    left: Said = (7.0, "r1", ViewJoined(epoch=NEXT))
    assert broken(run(left, (8.0, "r1", LOST))) == [("P1", 1)]


def test_the_tally_takes_entries_only_from_whom_they_concern() -> None:
    tally = Tally()
    foreign: list[Said] = [
        (8.0, "r2", LOST),
        (8.0, "r2", RobotStranded(epoch=EPOCH, robot=3, reason="no way")),
        (8.0, "r3", LeaderSucceeded(epoch=EPOCH, before=1)),
        (8.0, "r2", replace(formation(2, 3), epoch=NEXT)),
        (8.0, "r3", KILLED_2),
    ]
    for source, entry in lines_of(run(*foreign, (8.0, "r4", REACHED), without=("goal 1",))):
        tally.hear(source, entry)
    assert (tally.route_lost, tally.stranded, tally.goal_reached, tally.struck) == (None, {}, False, set())
    assert all(type(record) is not LeaderSucceeded for _, _, record in tally.recovery)
    assert tally.arrived == {1, 2, 3}


AGAIN = RobotStarted(pid=2, incarnation="j")
SPOKE: Said = (9.5, "r2", ViewJoined(epoch=EPOCH))
SEEN = RobotRestarted(robot=2, incarnation="j")
OF_WORLD = {
    each: FaultInjected(fault=each, rule="mine", process="world") for each in ("kill", "freeze", "thaw")
}


@pytest.mark.parametrize(
    ("further", "found"),
    [
        ([SPOKE], [("P7", 2)]),
        ([(9.4, "world", SEEN), SPOKE], []),
        ([SPOKE, (9.6, "world", SEEN)], []),
        ([], []),
        ([SPOKE, (9.6, "world", KILLED_2)], []),
        ([(9.4, "world", RouterLost()), SPOKE], []),
        ([(9.4, "world", OF_WORLD["kill"]), SPOKE], []),
        ([(9.4, "world", OF_WORLD["freeze"]), (9.4, "world", OF_WORLD["thaw"]), SPOKE], [("P7", 2)]),
        ([(9.4, "world", RouterLost()), (9.4, "world", RouterFound(away_s=0.0)), SPOKE], [("P7", 2)]),
    ],
    ids=[
        "unseen",
        "seen",
        "seen later",
        "only started",
        "killed before it was seen",
        "while the world sees no tokens",
        "while there is no world",
        "when the world goes on",
        "when it sees them again",
    ],
)
def test_a_process_counts_when_the_world_has_seen_its_token(
    further: list[Said], found: list[tuple[str, int]]
) -> None:
    assert broken(run((9.3, "r2", AGAIN), *further)) == found


def test_in_a_log_that_is_cut_off_the_token_of_a_process_may_be_to_come() -> None:
    assert broken(run((9.3, "r2", AGAIN), SPOKE), cut_off=True) == []


def test_a_log_without_incarnations_shows_nothing_about_tokens() -> None:
    voices = Voices()
    said: list[Said] = [
        (0.0, "world", RobotAppeared(robot=2)),
        (0.1, "r2", AGAIN),
        (0.2, "r2", ViewJoined(epoch=EPOCH)),
    ]
    for source, entry in lines_of(said):
        assert voices.hear(source, entry) is None
    assert list(voices.close()) == []
