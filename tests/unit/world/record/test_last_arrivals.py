"""Arrivals of a run whose world was killed at its end."""

import pytest

from protocol.exit_codes import ExitCode
from protocol.fence import NUMBERS
from protocol.keys import robot_name
from protocol.process.tokens import TokenCame
from protocol.timeline import Record, RobotArrived, RobotSettled, RunEnded, ViewJoined
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world.bodies.arena import TICK_S
from world.events import StopAsked
from world.judge.ending import Ending

BOUND_AGAIN = 1, ViewJoined(epoch=2 * NUMBERS)
BOUND, SETTLED = (2, ViewJoined(epoch=2 * NUMBERS)), (1, RobotSettled(sent={}))


def begun() -> Stage:
    """A run that has gone on for a second."""
    stage = Stage(scenario())
    stage.begin()
    stage.tick(round(1.0 / TICK_S))
    return stage


@pytest.mark.parametrize("entries", [(BOUND, SETTLED), (SETTLED, BOUND)])
@pytest.mark.parametrize(("before", "is_ended"), [(0, False), (1, False), (2, False), (2, True)])
def test_a_run_that_was_over_when_its_world_was_killed_loses_no_arrival(
    entries: tuple[tuple[int, Record], ...], before: int, *, is_ended: bool
) -> None:
    """A robot was bound in the tick in which the run ended; some entries come after the restart."""
    stage = begun()
    for robot in (1, 2):
        stage.write(robot, RobotArrived(progress_m=0.0))
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED
    over_s = stage.world.now_s
    for robot, record in entries[:before]:
        stage._write(robot_name(robot), over_s, record)
    if is_ended:
        stage._write("world", over_s + 1.0, RunEnded(reason=str(Ending.ARRIVED)))
    after = stage.resumed()
    for robot, record in entries[before:]:
        after._write(robot_name(robot), over_s, record)
    for robot in (1, 2):
        after.handle(TokenCame(robot, "a"))
    after.look()
    assert after.at()[2] is Ending.ARRIVED
    assert after.world.tally.arrived == {1, 2}


def test_a_run_in_which_no_robot_learned_of_the_end_loses_no_arrival_when_it_is_judged_again() -> None:
    before = begun()
    before.write(1, RobotArrived(progress_m=0.0))
    before.write(*BOUND_AGAIN)
    assert before.world.tally.arrived == set()
    before.handle(StopAsked(ExitCode.FAILED))
    assert before.world.tally.arrived == {1}
    before._write("world", before.world.now_s, RunEnded(reason=str(before.at()[2])))
    after = before.resumed()
    after.look()
    assert after.world.tally.arrived == {1}
