"""A robot's state follows from the timeline by transition tables; each pair is tested."""

import itertools

import pytest

from clew.story.robots import Robot, Robots
from clew.story.states import (
    ANEW,
    BEGINS,
    CONDUCT,
    ENDS,
    EVENTS,
    PROCESS,
    Conduct,
    Derived,
    Event,
    Kept,
    Process,
    State,
)
from clew.story.story import Story
from protocol.faults.process_faults import ProcessAction
from protocol.timeline import (
    BodyStopped,
    Entry,
    FaultInjected,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    PoseSampled,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotBlocked,
    RobotDied,
    RobotFailed,
    RobotHeld,
    RobotPlaced,
    RobotReleased,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RobotStranded,
    RouteLost,
    ScanServed,
    StrandJoined,
    ViewJoined,
    ViewLeft,
)
from tests.support.logs.logs import numbered
from tests.support.strands import formed, raised, strand, turn

HERE = {"x_m": 0.0, "y_m": 0.0}
E, F = 10_002, 20_003
"""The epochs of two views."""
AT_WORK: tuple[tuple[str, Record], ...] = (
    ("world", RobotAppeared(robot=1)),
    ("world", RobotAppeared(robot=2)),
    *strand(E, 2, 1),
)
KILLED: tuple[str, Record] = ("world", FaultInjected(fault="kill", rule="a", process="r1"))
FROZEN = ("world", FaultInjected(fault="freeze", rule="a", process="r1"))
THAWED = ("world", FaultInjected(fault="thaw", rule="a", process="r1"))
DIED = ("world", RobotDied(robot=1, silent_since_s=0.0))
SILENT = ("r1", LinkSilent(neighbour=2, silent_s=0.5))
BROKEN = ("r1", LinkBroken(neighbour=2, cause="token", silent_s=1.0))
HELD = ("r1", RobotHeld(behind_m=1.0))
STOPPED = ("world", BodyStopped(robot=1))
BOUND = ("r1", ViewJoined(epoch=F))
GIVEN = turn(F, 1, 1)
BLOCKED = ("r1", RobotBlocked(**HERE, turn=1, reason="x"))
LEFT = ("r1", ViewLeft(epoch=F))
STRANDED = ("r3", RobotStranded(epoch=F, robot=1, reason="x"))
ALL_EVENTS: list[Event] = sorted({*EVENTS, *ProcessAction, *Derived, ScanServed}, key=str)

RUNS: tuple[Event, ...] = (RobotAppeared, RobotStarted, RobotRestarted, RobotReturned)
PROCESS_AFTER: dict[Event, Process] = {
    **dict.fromkeys(RUNS, Process.RUNS),
    RobotDied: Process.DEAD,
    RobotFailed: Process.FAILED,
    ProcessAction.KILL: Process.KILLED,
    ProcessAction.FREEZE: Process.FROZEN,
}
CONDUCT_AFTER: dict[Event, Conduct] = {
    **dict.fromkeys((RobotStarted, RobotRestarted, ViewJoined), Conduct.BOUND),
    Derived.TURN_GIVEN: Conduct.JOINING,
    StrandJoined: Conduct.MEMBER,
    ViewLeft: Conduct.ASIDE,
    LinkBroken: Conduct.ADRIFT,
    RobotArrived: Conduct.ARRIVED,
    RouteLost: Conduct.NO_WAY,
}
CONDUCT_OF_ONE: dict[tuple[Conduct, Event], Conduct] = {
    (Conduct.JOINING, ViewJoined): Conduct.JOINING,
    (Conduct.JOINING, Derived.TURN_ENDED): Conduct.BOUND,
    (Conduct.MEMBER, Derived.BACKS_UP): Conduct.BACKING_UP,
}
"""Where it matters what the robot did before."""


@pytest.mark.parametrize(("before", "event"), list(itertools.product(Process, ALL_EVENTS)))
def test_the_process_changes_only_by_its_table(before: Process, event: Event) -> None:
    robot = Robot(1, process=before)
    robot.take(event)
    is_thawed = (before, event) == (Process.FROZEN, ProcessAction.THAW)
    assert robot.process is (Process.RUNS if is_thawed else PROCESS_AFTER.get(event, before))
    assert (robot.process is not before) <= ((before, event) in PROCESS)


@pytest.mark.parametrize(("before", "event"), list(itertools.product(Conduct, ALL_EVENTS)))
def test_the_conduct_changes_only_by_its_table(before: Conduct, event: Event) -> None:
    robot = Robot(1, conduct=before)
    robot.take(event)
    otherwise = before if before is Conduct.NO_WAY else CONDUCT_AFTER.get(event, before)
    after = CONDUCT_OF_ONE.get((before, event), otherwise)
    assert robot.conduct is after
    assert (after is not before) <= ((before, event) in CONDUCT)


@pytest.mark.parametrize(("before", "event"), list(itertools.product(Kept, ALL_EVENTS)))
def test_its_reasons_to_wait_begin_and_end_by_their_tables(before: Kept, event: Event) -> None:
    robot = Robot(1, kept={(before, 0)})
    robot.take(event)
    is_left = (before, event) == (Kept.STRANDED, ViewLeft)
    stays = ENDS.get(event) is not before and (event not in ANEW or before is Kept.STOPPED or is_left)
    begun = {BEGINS[event]} if event in BEGINS else set()
    assert {kept for kept, _ in robot.kept} == begun | ({before} if stays else set())


def heard(*records: tuple[str, Record]) -> Robots:
    story = Story()
    for source, entry in numbered(records):
        story.hear(source, entry)
    return story.robots


def seen(x_m: float) -> tuple[str, Record]:
    return "world", PoseSampled(robot=1, x_m=x_m, y_m=-3.0, heading_rad=0.0)


@pytest.mark.parametrize(
    ("records", "state"),
    [
        ([], State.FOLLOWING),
        ([SILENT], State.WAITING),
        ([SILENT, ("r1", LinkHeard(neighbour=2))], State.FOLLOWING),
        (
            [SILENT, ("r1", LinkSilent(neighbour=3, silent_s=0.5)), ("r1", LinkHeard(neighbour=2))],
            State.WAITING,
        ),
        ([HELD], State.HOLDING),
        ([HELD, SILENT], State.WAITING),
        ([HELD, ("r1", RobotReleased())], State.FOLLOWING),
        ([BROKEN], State.ADRIFT),
        ([HELD, BOUND], State.BOUND),
        ([BROKEN, BOUND], State.BOUND),
        ([BOUND, GIVEN], State.JOINING),
        ([GIVEN, BOUND], State.JOINING),
        ([BOUND, GIVEN, BLOCKED], State.BLOCKED),
        ([BOUND, GIVEN, BLOCKED, turn(F, 2), turn(F, 3, 1)], State.JOINING),
        ([BOUND, GIVEN, ("r1", RobotPlaced(**HERE, rank=1, turn=1))], State.JOINING),
        ([BOUND, GIVEN, ("r1", RobotPlaced(**HERE, rank=1, turn=1)), turn(F, 2)], State.BOUND),
        ([BOUND, GIVEN, raised(30_001)], State.BOUND),
        ([BOUND, GIVEN, turn(F, 2, 2)], State.BOUND),
        ([BOUND, LEFT], State.ASIDE),
        ([BOUND, LEFT, STRANDED], State.STRANDED),
        ([BOUND, STRANDED, LEFT], State.STRANDED),
        ([BOUND, STRANDED, LEFT, ("r1", ViewJoined(epoch=30_001))], State.BOUND),
        ([BOUND, LEFT, ("r2", RobotStranded(epoch=F, robot=2, reason="x"))], State.ASIDE),
        ([BOUND, *strand(F, 3, 1)], State.FOLLOWING),
        ([BOUND, *strand(F, 1, 2)], State.LEADING),
        ([BOUND, *strand(F, 1, 2, back_by_m=1.0)], State.BACKING_UP),
        (
            [BOUND, ("r1", StrandJoined(epoch=F, rank=1)), ("r2", formed(F, 2, 1, back_by_m=1.0))],
            State.BACKING_UP,
        ),
        ([BOUND, *strand(F, 1, 2, back_by_m=1.0), ("r1", ViewJoined(epoch=30_001))], State.BOUND),
        ([("r1", RobotArrived(progress_m=1.0))], State.ARRIVED),
        ([("r1", RobotArrived(progress_m=1.0)), BOUND], State.BOUND),
        ([("r1", RouteLost(reason="x"))], State.NO_WAY),
        ([("r1", RobotFailed(reason="x"))], State.FAILED),
        ([KILLED], State.KILLED),
        ([KILLED, THAWED], State.KILLED),
        ([KILLED, ("r1", RobotStarted(pid=7))], State.BOUND),
        ([("r1", FaultInjected(fault="kill", rule="a", process="r1"))], State.KILLED),
        ([FROZEN], State.FROZEN),
        ([FROZEN, THAWED], State.FOLLOWING),
        ([HELD, FROZEN, THAWED], State.HOLDING),
        ([DIED], State.DEAD),
        ([DIED, ("world", RobotReturned(robot=1))], State.FOLLOWING),
        ([DIED, ("world", RobotRestarted(robot=1))], State.BOUND),
        ([STOPPED], State.STOPPED),
        ([seen(0.0), STOPPED, seen(0.0)], State.STOPPED),
        ([seen(0.0), STOPPED, seen(0.1)], State.FOLLOWING),
        ([("world", FaultInjected(fault="drop", rule="a", key="link/r2/r1", number=1))], State.FOLLOWING),
        ([("world", FaultInjected(fault="kill", rule="a", process="world"))], State.FOLLOWING),
    ],
)
def test_state_follows_the_newest_entry(records: list[tuple[str, Record]], state: State) -> None:
    assert heard(*AT_WORK, *records).of(1).state is state


def test_the_first_robot_leads_and_an_unseen_robot_is_absent() -> None:
    robots = heard(*AT_WORK)
    assert [robots.of(robot).state for robot in (2, 1, 3)] == [State.LEADING, State.FOLLOWING, State.ABSENT]


def test_a_state_hidden_by_a_stopped_body_is_kept() -> None:
    last = heard(*AT_WORK, HELD, STOPPED).changes[-1]
    assert (last.state, last.doing) == (State.STOPPED, State.HOLDING)


def test_changes_of_a_robot_never_go_back_in_time() -> None:
    robots = Robots()
    for t_s, (source, record) in ((5.0, KILLED), (4.0, ("r1", RobotStarted(pid=7)))):
        robots.hear(source, Entry(n=1, t_s=t_s, hlc="0/0", record=record))
    assert [(change.t_s, change.state) for change in robots.changes] == [
        (5.0, State.KILLED),
        (5.0, State.BOUND),
    ]


def test_a_fault_on_an_unknown_robot_or_of_an_unknown_kind_is_ignored() -> None:
    strange = ("world", FaultInjected(fault="vaporise", rule="a", process="r1"))
    robots = heard(*AT_WORK, strange, ("world", FaultInjected(fault="kill", rule="a", process="r99")))
    assert robots.of(1).state is State.FOLLOWING
    assert robots.of(99).state is State.KILLED
