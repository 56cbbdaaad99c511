"""The end of a run in which robots die, freeze, return or cannot be heard."""

import pytest

from protocol.exit_codes import ExitCode
from protocol.fence import Cause, Fence, May, Raise, Release, Stop, Turn
from protocol.frames import Point
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import (
    LinkBroken,
    PoseSampled,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStranded,
    RunEnded,
    ViewJoined,
)
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage, life_of
from world.bodies.arena import TICK_S
from world.core import (
    HEAL_S_MAX,
    LAST_WORDS_WALL_S,
    MOVED_ON_S,
    ROBOTS_PATIENCE_WALL_S,
    ROUTER_PATIENCE_WALL_S,
    STRANDED_S,
)
from world.events import StopAsked
from world.judge.ending import Ending

SECOND = round(1.0 / TICK_S)


def running(**sections: dict[str, object]) -> Stage:
    stage = Stage(scenario(**sections))
    stage.begin()
    return stage


def test_a_death_does_not_end_the_run_and_the_others_arrive() -> None:
    stage = running()
    stage.tick(SECOND // 2)
    die(stage, 1)
    stage.tick(SECOND)
    stage.look()
    assert stage.at()[2] is None
    stage.write(2, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED


def die(stage: Stage, robot: int, *, incarnation: str = "a") -> None:
    stage.handle(TokenWent(robot, incarnation))
    stage.look(after_wall_s=1.0)
    assert [record for record in stage.records if isinstance(record, RobotDied)][-1].robot == robot


def test_a_run_that_ends_before_it_begins_has_no_samples_and_is_judged_by_its_end() -> None:
    stage = Stage(scenario())
    stage.handle(TokenCame(1, "a"))  # robot 2 never comes
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    stage.tick(3 * SECOND, awake=False)
    for _ in range(2):
        stage.look(after_wall_s=LAST_WORDS_WALL_S)
    assert stage.world.judgement is not None
    assert stage.world.judgement.failure is None
    assert not any(isinstance(each, PoseSampled) for each in stage.records)


def test_a_run_ends_if_all_robots_stay_away() -> None:
    stage = running()
    die(stage, 1)
    die(stage, 2)  # each death takes a second
    stage.look(after_wall_s=ROBOTS_PATIENCE_WALL_S - 2.1)
    assert stage.at()[2] is None
    stage.look(after_wall_s=0.2)
    assert stage.at()[2] is Ending.EXTINCT


def test_a_run_continues_after_all_robots_were_cut_off_for_a_time() -> None:
    stage = running()
    die(stage, 1)
    die(stage, 2)
    for robot in (1, 2):
        stage.handle(TokenCame(robot, "a"))
    stage.look(after_wall_s=ROBOTS_PATIENCE_WALL_S)
    assert stage.at()[2] is None
    for robot in (1, 2):
        stage.write(robot, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED


@pytest.mark.parametrize("upset", ["a death", "a broken link"])
def test_a_run_that_does_not_heal_ends_when_nothing_has_moved_for_the_longest_time(upset: str) -> None:
    stage = running(time={"time_s_max": 500.0})
    stage.order(2, Point(x_m=-1.5, y_m=0.0))
    if upset == "a death":
        die(stage, 1)
    else:
        stage.write(2, LinkBroken(neighbour=1, cause="silence", silent_s=3.0))
    stage.tick(round(HEAL_S_MAX * SECOND))
    stage.look()
    assert stage.at()[2] is None
    since_s = stage.world.arena.moved_s
    assert since_s > 1.0
    while stage.world.now_s < since_s + HEAL_S_MAX:
        assert stage.at()[2] is None
        stage.tick()
        stage.look()
    assert stage.at()[2] is Ending.STUCK


def test_a_robot_that_looks_for_a_way_in_its_turn_keeps_the_run_going() -> None:
    """As with eight robots and loss: five look for a way around a dead body, each several times."""
    stage = running(time={"time_s_max": 500.0})
    die(stage, 1)
    stage.tick(round(HEAL_S_MAX * SECOND) - SECOND)
    epoch = stage.fence.epoch.next(2, life_of(2))
    stage.put(2, Raise(epoch=epoch, cause=Cause.NEIGHBOUR_LOST))
    stage.put(2, Turn(fence=Fence(epoch=epoch, turn=1, may=May.ONE, robot=2, life=life_of(2))))
    stage.tick(round(HEAL_S_MAX * SECOND) - 1)
    stage.look()
    assert stage.at()[2] is None
    stage.tick()
    stage.look()
    assert stage.at()[2] is Ending.STUCK


def test_a_stop_by_the_operator_may_last_for_any_time() -> None:
    stage = running(time={"time_s_max": 500.0})
    die(stage, 1)
    stage.put(0, Stop())
    stage.tick(round(2 * HEAL_S_MAX * SECOND))
    stage.look()
    assert stage.at()[2] is None
    stage.put(0, Release(generation=stage.fence.epoch.generation))
    stage.tick(round(HEAL_S_MAX * SECOND) - 1)
    stage.look()
    assert stage.at()[2] is None
    stage.tick()
    stage.look()
    assert stage.at()[2] is Ending.STUCK


def test_without_a_death_or_a_broken_link_a_strand_may_stand_for_any_time() -> None:
    stage = running(time={"time_s_max": 500.0})
    stage.tick(round(2 * HEAL_S_MAX * SECOND))
    stage.look()
    assert stage.at()[2] is None


def test_a_frozen_robot_counts_as_dead_until_its_token_returns() -> None:
    stage = running()
    die(stage, 1)
    assert stage.handle(TokenCame(1, "a")) == [RobotReturned(robot=1)]
    stage.write(2, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[2] is None
    stage.write(1, RobotArrived(progress_m=2.0))
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED


def test_a_restarted_robot_has_died_is_alive_and_has_not_arrived() -> None:
    stage = running()
    stage.write(1, RobotArrived(progress_m=1.0))
    stage.tick(SECOND)
    stage.order(2, None, number=1)
    known = [RobotDied(robot=1, silent_since_s=0.0), RobotRestarted(robot=1, incarnation="b")]
    assert stage.handle(TokenCame(1, "b")) == known
    assert stage.odometry[1][-1].t_s == stage.world.now_s  # it gets the time at once
    stage.handle(TokenWent(1, "a"))
    stage.write(2, RobotArrived(progress_m=2.0))
    stage.look()
    assert stage.at()[2] is None
    die(stage, 1, incarnation="b")
    assert stage.handle(TokenCame(1, "c")) == [RobotRestarted(robot=1, incarnation="c")]


def look_without_router(stage: Stage, wall_s: float) -> None:
    for _ in range(10):
        stage.wall_s += wall_s / 10.0
        stage.world.look(wall_s=stage.wall_s, router=None)


def test_a_world_that_was_frozen_has_not_lost_its_router() -> None:
    stage = running()
    stage.look()
    stage.wall_s += 2.0 * ROUTER_PATIENCE_WALL_S
    stage.world.look(wall_s=stage.wall_s, router=None)
    stage.look(after_wall_s=0.1)
    assert stage.at()[2] is None


def test_without_a_router_no_robot_is_declared_dead_and_the_run_waits_for_a_time() -> None:
    stage = running()
    stage.look()
    for robot, incarnation in ((1, "a"), (2, "a")):
        stage.handle(TokenWent(robot, incarnation))
    look_without_router(stage, ROUTER_PATIENCE_WALL_S - 0.1)
    stage.look(after_wall_s=0.1)
    assert stage.at()[2] is None
    look_without_router(stage, ROUTER_PATIENCE_WALL_S)
    assert stage.at()[2] is Ending.CUT_OFF
    assert stage.world.tally.died == set()


def test_a_router_that_was_never_there_is_lost_after_the_same_time() -> None:
    stage = Stage(scenario())
    look_without_router(stage, ROUTER_PATIENCE_WALL_S - 0.1)  # the first look is a tenth of it later
    assert stage.at()[2] is None
    look_without_router(stage, 0.5 * ROUTER_PATIENCE_WALL_S)
    assert stage.at()[2] is Ending.CUT_OFF
    assert stage.world.judgement is not None


# --- stranded robots ------------------------------------------------------------------------------


def strand(stage: Stage, coordinator: int, robot: int) -> None:
    """The coordinator finds no way for a robot."""
    epoch = stage.fence.epoch.number
    stage.write(coordinator, RobotStranded(epoch=epoch, robot=robot, reason="a body plugs the way", by=1))


def form_without_second(stage: Stage) -> None:
    """A new view finds no way for robot 2, and forms the strand."""
    epoch = stage.fence.epoch.next(1, life_of(1)).number
    stage.write(1, RobotStranded(epoch=epoch, robot=2, reason="a body plugs the way"))
    stage.form()


def ends_within(stage: Stage, seconds: float) -> Ending | None:
    """How the run ends when time goes on for this long."""
    for _ in range(round(seconds * SECOND)):
        stage.tick()
        stage.look()
    return stage.at()[2]


def test_a_run_ends_a_while_after_the_last_robot_has_arrived_or_is_stranded() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    assert ends_within(stage, 5.0) is None
    stage.write(1, RobotArrived(progress_m=1.0))
    assert ends_within(stage, STRANDED_S - 1.0) is None
    assert ends_within(stage, 2.0) is Ending.STRANDED
    for _ in range(2):
        stage.look(after_wall_s=LAST_WORDS_WALL_S)
    assert stage.records[-1] == RunEnded(reason=f"{Ending.STRANDED}: r2")


def test_a_robot_that_a_later_formation_takes_in_is_not_stranded_any_more() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    stage.form()
    stage.write(1, RobotArrived(progress_m=1.0))
    assert ends_within(stage, 2 * STRANDED_S) is None


def test_a_robot_of_which_the_newest_formation_says_it_stays_stranded() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    stage.form()
    strand(stage, 1, 2)
    stage.write(1, RobotArrived(progress_m=1.0))
    assert ends_within(stage, STRANDED_S + 1.0) is Ending.STRANDED


@pytest.mark.parametrize("drives_on", [False, True])
def test_robots_that_are_stranded_again_after_an_arrival_are_waited_for_only_if_a_body_moves_on(
    *, drives_on: bool
) -> None:
    stage = running(time={"time_s_max": 500.0})
    stage.tick(SECOND)
    for again in (False, True):
        form_without_second(stage)
        if again and drives_on:
            stage.order(1, Point(x_m=0.12, y_m=0.0))
            stage.tick(SECOND)
        stage.write(1, RobotArrived(progress_m=1.0))
        ending = ends_within(stage, 1.0)
        assert ending is (Ending.STRANDED if again and not drives_on else None)
    assert ends_within(stage, STRANDED_S) is Ending.STRANDED


@pytest.mark.parametrize("upset", ["between the formations", "after them"])
def test_robots_that_are_stranded_again_are_waited_for_if_a_link_has_broken_meanwhile(upset: str) -> None:
    stage = running(time={"time_s_max": 500.0})
    stage.tick(SECOND)
    for again in (False, True):
        form_without_second(stage)
        stage.write(1, RobotArrived(progress_m=1.0))
        if again is (upset == "after them"):
            stage.write(1, LinkBroken(neighbour=2, cause="silence", silent_s=3.0))
        assert ends_within(stage, STRANDED_S - 2.0) is None
    assert ends_within(stage, 3.0) is Ending.STRANDED


@pytest.mark.parametrize("moves", [True, False])
def test_while_obstacles_move_robots_that_are_stranded_again_are_waited_for_since_a_way_may_open(
    *, moves: bool
) -> None:
    """One of which all have come to rest, a while ago, opens no way."""
    track = [[0.0, -3.0, 2.0], [1.0, -3.0, 2.1], *[[400.0, -3.0, 2.2]] * moves]
    door = {"id": "door", "shape": "circle", "radius_m": 0.3, "track": track}
    stage = Stage(scenario(door, time={"time_s_max": 500.0}))
    stage.begin()
    stage.tick(SECOND)
    for again in (False, True):
        form_without_second(stage)
        stage.write(1, RobotArrived(progress_m=1.0))
        ending = ends_within(stage, MOVED_ON_S - 1.0)
        assert ending is (Ending.STRANDED if again and not moves else None)
    assert ends_within(stage, 2.0) is Ending.STRANDED


def test_robots_that_were_stranded_as_obstacles_came_to_rest_are_waited_for_until_they_have_tried_again() -> (
    None
):
    track = [[0.0, -3.0, 2.0], [100.0, -3.0, 2.2]]
    door = {"id": "door", "shape": "circle", "radius_m": 0.3, "track": track}
    stage = Stage(scenario(door, time={"time_s_max": 500.0}))
    stage.begin()
    for formed_s, ends in ((90.0, False), (98.0, False), (131.0, False), (133.0, True)):
        while stage.world.now_s < formed_s:
            stage.tick()
        form_without_second(stage)
        stage.write(1, RobotArrived(progress_m=1.0))
        assert (ends_within(stage, 1.0) is Ending.STRANDED) is ends


def test_robots_that_join_another_view_have_not_arrived() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    stage.write(1, RobotArrived(progress_m=1.0))
    stage.write(1, ViewJoined(epoch=30_001))
    assert ends_within(stage, 2 * STRANDED_S) is None


def test_a_robot_that_has_arrived_keeps_that_when_the_run_is_over_before_it_is_in_another_view() -> None:
    stage = running()
    for robot in (1, 2):
        stage.write(robot, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED
    stage.write(1, ViewJoined(epoch=20002))
    assert stage.world.tally.arrived == {1, 2}


def test_where_nobody_has_arrived_that_lives_a_stranded_robot_may_lead_yet() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    stage.write(1, RobotArrived(progress_m=1.0))
    die(stage, 1)
    assert ends_within(stage, 2 * STRANDED_S) is None


def test_a_stranded_robot_that_dies_is_not_waited_for() -> None:
    stage = running(time={"time_s_max": 500.0})
    strand(stage, 1, 2)
    stage.write(1, RobotArrived(progress_m=1.0))
    die(stage, 2)
    stage.look()
    assert stage.at()[2] is Ending.ARRIVED
