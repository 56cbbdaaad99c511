import pytest

from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.process.tokens import TokenWent
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world import answers
from world.answers import SLACK_S
from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.events import StopAsked
from world.pace import GLANCE_S, HELD_S_MAX, PATIENCE_S, REMIND_S, REPEAT_S, REPEAT_S_PER_ROBOT, Pace

ODOMETRY_S = ODOMETRY_TICKS * TICK_S


def running(in_all: int = 2) -> Stage:
    stage = Stage(scenario(), in_all=in_all)
    stage.begin()
    return stage


def answered(stage: Stage) -> None:
    for robot in (1, 2):
        stage.order(robot, Point(x_m=0.0, y_m=0.0), number=0)


def ticks_due(stage: Stage, pace: Pace, *, wall_s: float, answering: bool = False) -> int:
    ticks = 0
    stage.wall_s = wall_s
    while pace.wait_s(stage.world, wall_s=wall_s) <= 0.0:
        stage.tick(awake=False)
        if answering:
            answered(stage)
        pace.ticked(stage.world, wall_s=wall_s)
        ticks += 1
    return ticks


def test_no_tick_is_due_before_all_robots_have_come() -> None:
    assert Pace(1.0).wait_s(Stage(scenario()).world, wall_s=5.0) == GLANCE_S


@pytest.mark.parametrize("speed", [0.5, 1.0, 10.0])
def test_ticks_are_due_at_the_requested_speed(speed: float) -> None:
    stage, pace = running(), Pace(speed)
    answered(stage)
    ticks = sum(
        ticks_due(stage, pace, wall_s=7.0 + milliseconds / 1000, answering=True)
        for milliseconds in range(1000)
    )
    assert ticks == pytest.approx(speed / TICK_S, abs=1)


def test_a_late_world_catches_up_by_one_odometry_period_at_most() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    assert ticks_due(stage, pace, wall_s=0.0, answering=True) == 1
    assert ticks_due(stage, pace, wall_s=60.0, answering=True) <= 2 * ODOMETRY_TICKS


def run_for(stage: Stage, pace: Pace, *, from_wall_s: float, for_s: float, robots: tuple[int, ...]) -> None:
    """The wall clock passes; these robots answer at once, and the others never."""
    for hundredths in range(round(100 * for_s)):
        stage.wall_s = from_wall_s + hundredths / 100
        while pace.wait_s(stage.world, wall_s=stage.wall_s) <= 0.0:
            stage.tick(awake=False)
            for robot in robots:
                stage.order(robot, None, number=0)
            pace.ticked(stage.world, wall_s=stage.wall_s)


def test_the_clock_waits_for_a_late_robot_that_shows_its_token_and_goes_on_when_it_has_answered() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=5.0, robots=(1,))
    held_s = stage.world.now_s
    assert held_s == pytest.approx(SLACK_S + ODOMETRY_S, abs=TICK_S)
    answered(stage)
    run_for(stage, pace, from_wall_s=5.0, for_s=1.0, robots=(1, 2))
    assert stage.world.now_s - held_s == pytest.approx(1.0, abs=2 * ODOMETRY_S)


def test_the_clock_gives_up_a_robot_that_does_not_answer_at_all() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=20.0, robots=(1,))
    assert stage.world.now_s > 20.0 - answers.PATIENCE_S - 1.0


def test_on_a_machine_that_is_not_late_the_clock_does_not_wait_for_a_robot_without_a_token() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    stage.handle(TokenWent(2, "a"))
    run_for(stage, pace, from_wall_s=0.0, for_s=5.0, robots=(1,))
    assert stage.world.now_s == pytest.approx(5.0, abs=0.1)


def test_on_a_late_machine_the_clock_waits_for_a_robot_that_has_lost_its_token() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    stage.world.answers.lateness.hear(0.5, 0.0)
    stage.handle(TokenWent(2, "a"))
    run_for(stage, pace, from_wall_s=0.0, for_s=2.0, robots=(1,))
    assert stage.world.now_s < SLACK_S + 2 * ODOMETRY_S
    assert stage.look() == [], "and does not take it for dead"


def test_the_clock_waits_for_nobody_whom_a_fault_holds_up() -> None:
    stage, pace = running(), Pace(1.0, lambda robot: robot == 2)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=5.0, robots=(1,))
    assert stage.world.now_s == pytest.approx(5.0, abs=0.1)


def test_odometry_is_sent_again_to_a_robot_that_is_late_but_seldom() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=1.0, robots=(1,))
    told_s = stage.wall_s
    assert pace.take_reminder(stage.world, wall_s=told_s + REPEAT_S) == {2}
    assert pace.take_reminder(stage.world, wall_s=told_s + 1.5 * REPEAT_S) == set()
    assert pace.take_reminder(stage.world, wall_s=told_s + 2 * REPEAT_S) == {2}


def test_beside_many_robots_of_other_fleets_it_is_sent_again_no_sooner_than_all_may_answer() -> None:
    stage, pace = running(in_all=1000), Pace(1.0)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=1.0, robots=(1,))
    assert pace.take_reminder(stage.world, wall_s=stage.wall_s + REPEAT_S) == set()
    assert pace.take_reminder(stage.world, wall_s=stage.wall_s + 1000 * REPEAT_S_PER_ROBOT) == {2}


def test_the_speed_reached_does_not_count_a_stop_on_purpose() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    assert pace.speed_reached is None
    run_for(stage, pace, from_wall_s=0.0, for_s=4.0, robots=(1, 2))
    assert pace.speed_reached == pytest.approx(1.0, abs=0.02)
    pace.resume()
    run_for(stage, pace, from_wall_s=8.0, for_s=4.0, robots=(1, 2))
    assert pace.speed_reached == pytest.approx(1.0, abs=0.05)


def test_the_speed_reached_counts_what_the_clock_has_waited() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    run_for(stage, pace, from_wall_s=0.0, for_s=4.0, robots=(1, 2))
    run_for(stage, pace, from_wall_s=12.0, for_s=4.0, robots=(1, 2))
    assert pace.speed_reached == pytest.approx(0.5, abs=0.05)


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


def test_a_held_run_goes_only_as_far_as_it_is_asked_to() -> None:
    stage, pace = running(), Pace(None, held_at_s=0.0)
    answered(stage)
    assert ticks_due(stage, pace, wall_s=1.0, answering=True) == 0
    pace.go(1.0, wall_s=2.0)
    assert ticks_due(stage, pace, wall_s=2.0, answering=True) == pytest.approx(1.0 / TICK_S, abs=1)
    assert ticks_due(stage, pace, wall_s=2.0 + HELD_S_MAX, answering=True) == 0


def test_a_held_run_whose_test_is_dead_is_released() -> None:
    stage, pace = running(), Pace(None, held_at_s=0.0)
    answered(stage)
    assert ticks_due(stage, pace, wall_s=1.0) == 0
    assert ticks_due(stage, pace, wall_s=1.1 + HELD_S_MAX) == ODOMETRY_TICKS


def test_a_run_that_is_over_is_not_held() -> None:
    stage, pace = running(), Pace(None, held_at_s=0.0)
    pace.wait_s(stage.world, wall_s=0.0)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    assert ticks_due(stage, pace, wall_s=2.0) > 0


def test_lock_step_ends_with_the_run() -> None:
    stage, pace = running(), Pace(None)
    pace.wait_s(stage.world, wall_s=0.0)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    ticks = sum(ticks_due(stage, pace, wall_s=2.0 + milliseconds / 1000) for milliseconds in range(1000))
    assert ticks == pytest.approx(1.0 / TICK_S, abs=2 * ODOMETRY_TICKS)


def test_a_tick_is_late_from_when_it_was_due_until_it_is_made() -> None:
    stage, pace = running(), Pace(1.0)
    answered(stage)
    wall_s = 7.0
    for late_s in [0.0] * 60 + [0.015] * 40 + [0.5]:
        due_s = wall_s + late_s
        assert ticks_due(stage, pace, wall_s=due_s, answering=True) >= 1
        wall_s = due_s + pace.wait_s(stage.world, wall_s=due_s)
    late = pace.late
    assert late is not None
    assert late.p50_s == pytest.approx(0.0, abs=0.001)
    assert 0.015 <= late.p99_s <= 0.5


def test_ticks_in_lock_step_are_never_late() -> None:
    stage, pace = running(), Pace(None)
    answered(stage)
    ticks_due(stage, pace, wall_s=7.0, answering=False)
    assert pace.late is None
