"""The world and the fence: who is told of a change, what is recorded, and when."""

from itertools import pairwise

import pytest

from protocol.exit_codes import ExitCode
from protocol.fence import Cause, Fence, May, Raise, Release, Stop, Turn
from protocol.frames import Point
from protocol.process.tokens import TokenCame
from protocol.timeline import FenceChanged, OrderRefused, PoseSampled
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage, life_of
from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.commands import Note, TellOdometry
from world.events import FencePut, ScanAsked, StopAsked
from world.quota import RAISES_MAX

SECOND = round(1.0 / TICK_S)
FAR = Point(x_m=1.0, y_m=0.0)


def running() -> Stage:
    stage = Stage(scenario())
    stage.begin()
    return stage


def a_raise(stage: Stage, robot: int) -> Raise:
    return Raise(epoch=stage.fence.epoch.next(robot, life_of(robot)), cause=Cause.NEIGHBOUR_LOST)


def test_a_change_is_recorded_and_then_told_to_all_robots_at_once() -> None:
    stage = running()
    stage.tick(ODOMETRY_TICKS + 2)
    commands = stage.world.handle(FencePut(2, a_raise(stage, 2)), wall_s=0.0)
    note, *told = commands
    assert isinstance(note, Note)
    assert note.record == FenceChanged(
        epoch=20_002, turn=0, may=May.NOBODY, coordinator=2, life="66", cause=Cause.NEIGHBOUR_LOST
    )
    assert [each.robot for each in told if isinstance(each, TellOdometry)] == [1, 2]
    assert {each.odometry.fence for each in told if isinstance(each, TellOdometry)} == {stage.fence}


def test_a_turn_is_recorded_with_whom_it_names_and_without_a_cause() -> None:
    stage = running()
    stage.put(2, a_raise(stage, 2))
    turn = Fence(epoch=stage.fence.epoch, turn=1, may=May.ONE, robot=1, life=life_of(1))
    assert stage.put(2, Turn(fence=turn)) == [
        FenceChanged(
            epoch=20_002, turn=1, may=May.ONE, coordinator=2, life="66", named=1, named_life="65", cause=None
        )
    ]


def test_a_put_that_changes_nothing_is_neither_recorded_nor_told() -> None:
    stage = running()
    change = a_raise(stage, 2)
    stage.put(2, change)
    assert stage.world.handle(FencePut(2, change), wall_s=0.0) == []


def test_a_change_stops_every_body_where_it_is_and_drops_its_order() -> None:
    stage = running()
    stage.order(1, FAR)
    stage.order(2, Point(x_m=-1.5, y_m=0.0))
    stage.tick(SECOND // 2 + 1)
    records = stage.put(2, a_raise(stage, 2))
    assert [type(each) for each in records] == [PoseSampled, PoseSampled, FenceChanged]
    stood_m = stage.world.bodies.place_m.tolist()
    records = stage.tick(SECOND)
    assert stage.world.bodies.place_m.tolist() == stood_m
    told = stage.odometry[1][-1]
    assert (told.ordered, told.finished, told.moving) == (1, 0, False)


def test_an_order_in_flight_when_the_fence_changed_is_refused_and_names_both() -> None:
    stage = running()
    old = stage.bearing(1)
    stage.put(2, a_raise(stage, 2))
    (refused,) = stage.order(1, FAR, bearing=old)
    assert isinstance(refused, OrderRefused)
    assert (refused.epoch, refused.turn, refused.fence, refused.fence_turn) == (10_001, 1, 20_002, 0)


def test_odometry_is_numbered_and_tells_for_how_long_all_bodies_have_stood() -> None:
    stage = running()
    stage.tick(SECOND)
    assert stage.odometry[2][-1].stood_s == pytest.approx(1.0)
    stage.order(1, Point(x_m=0.5, y_m=0.0))  # for a second
    stage.tick(ODOMETRY_TICKS)
    assert stage.odometry[2][-1].stood_s == 0.0  # another body drives
    stage.tick(2 * SECOND)
    assert stage.odometry[2][-1].stood_s == pytest.approx(1.1, abs=2 * TICK_S)
    assert all(before.n < after.n for before, after in pairwise(stage.odometry[2]))


def test_a_body_that_the_fence_has_stopped_has_stood_from_then_on() -> None:
    stage = running()
    stage.order(1, FAR)
    stage.tick(SECOND)
    stage.put(2, a_raise(stage, 2))
    assert stage.odometry[2][-1].stood_s == 0.0
    stage.tick(SECOND)
    assert stage.odometry[2][-1].stood_s == pytest.approx(1.0)


def test_a_scan_bears_the_fence_under_which_it_was_taken() -> None:
    stage = running()
    stage.handle(ScanAsked(1, 1))
    stage.put(2, a_raise(stage, 2))
    stage.handle(ScanAsked(1, 1))
    assert [scan.fence.key for scan in stage.scans] == [(1, 1, 1), (2, 2, 0)]


def test_the_operator_stops_the_fleet_and_releases_it() -> None:
    stage = running()
    stage.order(1, FAR)
    stage.tick(SECOND)
    stage.put(0, Stop())
    assert stage.fence.may is May.STOPPED
    assert not stage.world.bodies.moving.any()
    assert stage.put(1, a_raise(stage, 1)) == []
    stage.put(0, Release(generation=stage.fence.epoch.generation))
    assert stage.put(1, a_raise(stage, 1)) != []


def test_before_the_clock_starts_and_when_the_run_is_over_the_fence_stays() -> None:
    stage = Stage(scenario())
    stage.handle(TokenCame(1, "a"))
    assert stage.put(1, a_raise(stage, 1)) == []
    stage = running()
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    assert stage.put(1, a_raise(stage, 1)) == []


def test_a_world_that_was_started_again_in_a_rehearsal_raises_the_fence_and_tells_it() -> None:
    stage = running()
    stage.order(1, FAR)
    told = stage.world.restart(wall_s=0.0)
    assert stage.fence.epoch.generation == 2
    assert [type(each) for each in told] == [Note, Note, TellOdometry, TellOdometry]
    assert not stage.world.bodies.moving.any()


def test_a_robot_that_has_no_raise_left_has_none_in_a_resumed_world() -> None:
    before = running()
    raises = [before.put(2, a_raise(before, 2)) != [] for _ in range(RAISES_MAX + 1)]
    assert raises == [True] * RAISES_MAX + [False]
    after = before.resumed()
    assert after.put(2, a_raise(after, 2)) == []
    assert after.put(1, a_raise(after, 1)) != []
