"""The scoreboard of a run: entries in, rows out. Its final numbers equal the verdict's."""

from pathlib import Path

import msgspec
import pytest

from clew.fleet.table_rows import Row, Scoreboard
from clew.log.log import Log
from clew.story.states import State
from protocol.fence import Cause, May
from protocol.frames import Point
from protocol.timeline import (
    FaultInjected,
    FenceChanged,
    GoalReached,
    LinkSilent,
    PoseSampled,
    PromiseBroken,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotFailed,
    RobotReturned,
    StepPlanned,
)
from tests.support.logs.logs import HEADER, numbered
from tests.support.runs import Runs
from tests.support.strands import formed, ordered, strand
from world.record.run_files import read_verdict

HERE = {"x_m": 0.0, "y_m": 0.0}
AT_WORK: tuple[tuple[str, Record], ...] = (
    ("world", RobotAppeared(robot=1)),
    ("world", RobotAppeared(robot=2)),
    *strand(1, 2, 1),
)


def board(*records: tuple[str, Record]) -> Scoreboard:
    board = Scoreboard.of(HEADER)
    for source, entry in numbered(records):
        board.hear(source, entry)
    return board


def row_of(robot: int, *records: tuple[str, Record]) -> Row:
    return next(row for row in board(*records).rows if row.robot == robot)


def planned(step: int, *, x_m: float, reach_m: float, cost_to_go_m: float | None) -> StepPlanned:
    return StepPlanned(
        x_m=0.0,
        y_m=0.0,
        step=step,
        epoch=1,
        law="certified",
        obstacles=(),
        gaps=(),
        gap=None,
        heading_rad=0.0,
        length_m=x_m,
        target=Point(x_m=x_m, y_m=0.0),
        reach_m=reach_m,
        promised_clearance_m=None,
        cost_to_go_m=cost_to_go_m,
    )


def seen(robot: int, x_m: float) -> tuple[str, Record]:
    return "world", PoseSampled(robot=robot, x_m=x_m, y_m=-3.0, heading_rad=0.0)


@pytest.fixture(scope="module", params=["leader-killed", "loss-50"])
def run(request: pytest.FixtureRequest, runs: Runs) -> Path:
    """A rehearsal with faults."""
    return runs.of("grove", faults=str(request.param))


def heard(run: Path, *, looks: int) -> Scoreboard:
    """The board after a whole run; its rows were read this often on the way."""
    log = Log(run)
    board, lines = Scoreboard.of(log.header), list(log.lines)
    for number, (source, entry) in enumerate(lines):
        board.hear(source, entry)
        if looks and number % (len(lines) // looks) == 0:
            assert board.rows
    return board


def test_final_numbers_equal_the_verdicts(run: Path) -> None:
    board, verdict = heard(run, looks=20), read_verdict(run)
    rows = board.rows
    assert min(row.clearance_m_min or 0.0 for row in rows) == pytest.approx(verdict.clearance_m_min, abs=1e-9)
    assert sum(row.driven_m for row in rows) == pytest.approx(verdict.path_m, abs=1e-9)
    assert sum(row.lost for row in rows) == sum(verdict.messages.injected.values())
    assert len([row for row in rows if row.state is State.ARRIVED]) == verdict.robots_arrived
    assert len([row for row in rows if row.state is State.DEAD]) == len(verdict.deaths)
    assert board.story.steps.finished_count == verdict.switching_steps <= board.step
    assert board.ended == verdict.reason


def test_rows_do_not_depend_on_how_often_they_are_read(run: Path) -> None:
    assert heard(run, looks=0).rows == heard(run, looks=50).rows


def test_rows_follow_the_strand_then_robots_without_a_place() -> None:
    rows = board(*AT_WORK).rows
    assert [(row.robot, row.place) for row in rows[:2]] == [(2, 0), (1, 1)]
    assert rows[0].state is State.LEADING
    assert {row.state for row in rows[2:]} == {State.ABSENT}


def test_a_waiting_robot_names_the_robot_it_waits_for() -> None:
    waiting = row_of(1, *AT_WORK, ("r1", LinkSilent(neighbour=2, silent_s=0.5)))
    assert waiting.about == (2,)
    assert row_of(2, *AT_WORK).about == ()


def test_dead_leader_loses_its_place_to_the_new_leader() -> None:
    killed = ("world", FaultInjected(fault="kill", rule="a", process="r2"))
    rows = board(*AT_WORK, killed, *strand(2, 1)).rows
    assert [row.robot for row in rows if row.place == 0] == [1]


def test_progress_is_the_driven_share_of_path_and_cost_to_go() -> None:
    plan = planned(1, x_m=2.0, reach_m=3.0, cost_to_go_m=5.0)
    order = ordered(2, epoch=1, step=1, y_m=-3.0, target=Point(x_m=2.0, y_m=-3.0), reach_m=3.0)
    begun = (*AT_WORK, seen(2, 0.0), ("r2", plan), ("world", order))
    assert row_of(2, *begun).share == 0.0
    half = row_of(2, *begun, seen(2, 1.0))
    assert (half.step, half.driven_m) == (1, 1.0)
    assert half.share == pytest.approx(1.0 / 7.0)  # of 2 m to the target and 5 m from there
    assert row_of(2, *begun, seen(2, 1.0), ("r2", RobotArrived(progress_m=8.0))).share == 1.0


def test_orders_of_a_turn_of_the_same_view_say_nothing_of_progress_in_its_strand() -> None:
    plan = planned(1, x_m=2.0, reach_m=3.0, cost_to_go_m=5.0)
    order = ordered(2, epoch=1, turn=0, y_m=-3.0, target=Point(x_m=2.0, y_m=-3.0), reach_m=3.0)
    assert row_of(2, *AT_WORK, seen(2, 0.0), ("r2", plan), ("world", order)).share is None


def test_a_stop_by_the_operator_is_seen_until_it_is_released() -> None:
    stop = FenceChanged(epoch=20_000, turn=0, may=May.STOPPED, coordinator=0, life="", cause=Cause.OPERATOR)
    released = msgspec.structs.replace(stop, epoch=30_000, may=May.NOBODY)
    assert board(*AT_WORK, ("world", stop)).is_stopped
    assert not board(*AT_WORK, ("world", stop), ("world", released)).is_stopped


def test_there_is_no_progress_without_a_goal() -> None:
    plan = planned(1, x_m=2.0, reach_m=3.0, cost_to_go_m=None)
    assert row_of(2, *AT_WORK, seen(2, 0.0), ("r2", plan), seen(2, 1.0)).share is None


def test_a_fault_on_an_unknown_robot_makes_no_row() -> None:
    rows = board(*AT_WORK, ("world", FaultInjected(fault="kill", rule="a", process="r99"))).rows
    assert [row.robot for row in rows] == [2, 1, 3, 4, 5]


def test_escape_sequences_from_a_log_do_not_reach_the_terminal() -> None:
    shown = board(*AT_WORK, ("r1", RobotFailed(reason="\x1b[2J"))).events[-1]
    assert shown.endswith("r1 has failed: \\x1b[2J")


def test_broken_promises_are_counted_and_the_event_list_is_bounded() -> None:
    broken = PromiseBroken(invariant="S1", robot=1, measured_m=0.0, required_m=0.1, why="near")
    told = board(*AT_WORK, *(("world", broken),) * 3, *(("r2", GoalReached(**HERE)),) * 50)
    assert told.broken == 3
    assert len(told.events) == told.events.maxlen


@pytest.mark.parametrize(
    ("source", "record"),
    [
        ("world", FaultInjected(fault="kill", rule="by-hand", process="r99")),
        ("world", FaultInjected(fault="drop", rule="lossy", key="link")),
        ("world", PoseSampled(robot=99, x_m=0.0, y_m=0.0, heading_rad=0.0)),
        ("world", RobotReturned(robot=99)),
        ("r99", formed(1, 2, 1)),
        ("r99", RobotArrived(progress_m=1.0)),
    ],
)
def test_entries_about_unknown_robots_make_no_row(source: str, record: Record) -> None:
    rows = board(*AT_WORK, (source, record)).rows
    assert [row.robot for row in rows] == [row.robot for row in board(*AT_WORK).rows]
    assert all(row.lost == 0 for row in rows)
