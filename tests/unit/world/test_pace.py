import pytest

from protocol.exit_codes import ExitCode
from protocol.frames import Point
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.events import StopAsked
from world.pace import GLANCE_S, PATIENCE_S, REMIND_S, Pace


def running() -> Stage:
    stage = Stage(scenario())
    stage.begin()
    return stage


def answered(stage: Stage) -> None:
    for robot in (1, 2):
        stage.order(robot, Point(x_m=0.0, y_m=0.0), number=0)


def ticks_due(stage: Stage, pace: Pace, *, wall_s: float) -> int:
    ticks = 0
    while pace.wait_s(stage.world, wall_s=wall_s) <= 0.0:
        stage.tick(awake=False)
        pace.ticked(stage.world, wall_s=wall_s)
        ticks += 1
    return ticks


def test_no_tick_is_due_before_all_robots_have_come() -> None:
    assert Pace(1.0).wait_s(Stage(scenario()).world, wall_s=5.0) == GLANCE_S


@pytest.mark.parametrize("speed", [0.5, 1.0, 10.0])
def test_ticks_are_due_at_the_requested_speed(speed: float) -> None:
    stage, pace = running(), Pace(speed)
    ticks = sum(ticks_due(stage, pace, wall_s=7.0 + milliseconds / 1000) for milliseconds in range(1000))
    assert ticks == pytest.approx(speed / TICK_S, abs=1)


def test_a_late_world_catches_up_by_one_odometry_period_at_most() -> None:
    stage, pace = running(), Pace(1.0)
    assert ticks_due(stage, pace, wall_s=0.0) == 1
    assert ticks_due(stage, pace, wall_s=60.0) <= 2 * ODOMETRY_TICKS


def test_lock_step_ticks_at_once_when_all_robots_have_answered() -> None:
    stage, pace = running(), Pace(None)
    assert pace.wait_s(stage.world, wall_s=0.0) > 0.0
    answered(stage)
    assert ticks_due(stage, pace, wall_s=0.0) == ODOMETRY_TICKS  # then all robots have odometry to answer


def test_lock_step_waits_for_a_robot_at_most_its_patience() -> None:
    stage, pace = running(), Pace(None)
    assert pace.wait_s(stage.world, wall_s=0.0) > 0.0
    assert ticks_due(stage, pace, wall_s=PATIENCE_S - 0.01) == 0
    assert ticks_due(stage, pace, wall_s=PATIENCE_S) == 1


def test_lock_step_sends_odometry_again_to_robots_without_an_answer() -> None:
    stage, pace = running(), Pace(None)
    pace.wait_s(stage.world, wall_s=100.0)
    assert pace.take_reminder(stage.world, wall_s=100.0)
    assert not pace.take_reminder(stage.world, wall_s=100.0 + REMIND_S / 2)
    assert pace.take_reminder(stage.world, wall_s=100.0 + 2 * REMIND_S)
    answered(stage)
    assert not pace.take_reminder(stage.world, wall_s=200.0)


def test_lock_step_ends_with_the_run() -> None:
    stage, pace = running(), Pace(None)
    pace.wait_s(stage.world, wall_s=0.0)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    ticks = sum(ticks_due(stage, pace, wall_s=2.0 + milliseconds / 1000) for milliseconds in range(1000))
    assert ticks == pytest.approx(1.0 / TICK_S, abs=2 * ODOMETRY_TICKS)
