"""The promises, each kept and broken."""

import pytest

from clew.explore.explorable import Breach
from clew.explore.judge import judge_change, judge_member, judge_order, judge_places, judge_plan
from protocol.fence import Bearing, Epoch, Fence, May
from protocol.frames import Point, Pose
from protocol.timeline import StrandFormed
from protocol.wire.messages import Drive, Scan

FIRST = Fence()
VIEW = Fence(epoch=Epoch(generation=1, robot=2, life=20))
TURN_1 = Fence(epoch=VIEW.epoch, turn=1, may=May.ONE, robot=3, life=30)
TURN_2 = Fence(epoch=VIEW.epoch, turn=2)
ALL = Fence(epoch=VIEW.epoch, turn=3, may=May.ALL, robot=1, members=2)
STOPPED = Fence(epoch=Epoch(generation=2), may=May.STOPPED)
HIGHER = Fence(epoch=Epoch(generation=1, robot=3, life=30))


@pytest.mark.parametrize(
    ("before", "now", "put_by"),
    [
        (FIRST, VIEW, 2),
        (VIEW, HIGHER, 3),
        (VIEW, TURN_1, 2),
        (TURN_1, TURN_2, 2),
        (TURN_2, ALL, 2),
        (ALL, STOPPED, 0),
        (STOPPED, Fence(epoch=Epoch(generation=3)), 0),
    ],
)
def test_a_fence_may_go_on_as_the_rules_of_the_fence_say(before: Fence, now: Fence, put_by: int) -> None:
    judge_change(before, now, put_by)


@pytest.mark.parametrize(
    ("before", "now", "put_by"),
    [
        (VIEW, FIRST, 0),
        (HIGHER, VIEW, 2),
        (TURN_1, HIGHER, 3),
        (VIEW, TURN_2, 2),
        (TURN_2, TURN_1, 2),
        (VIEW, TURN_1, 3),
        (ALL, Fence(epoch=VIEW.epoch, turn=4), 2),
        (FIRST, TURN_1, 2),
        (STOPPED, Fence(epoch=Epoch(generation=3, robot=1, life=10)), 1),
    ],
)
def test_fences_that_go_on_otherwise_break_f3(before: Fence, now: Fence, put_by: int) -> None:
    with pytest.raises(Breach, match="F3"):
        judge_change(before, now, put_by)


def order(fence: Fence, life: int) -> Drive:
    return Drive(
        number=1,
        basis_s=0.0,
        target=Point(x_m=1.0, y_m=0.0),
        speed_mps=0.5,
        bearing=Bearing(epoch=fence.epoch, turn=fence.turn, life=life),
        step=0,
        reach_m=1.0,
    )


def test_a_robot_orders_motion_only_under_the_fence_that_was_told_and_names_it() -> None:
    judge_order(3, 30, order(TURN_1, 30), TURN_1)
    for told in (None, VIEW, TURN_2, ALL):
        with pytest.raises(Breach, match="F2"):
            judge_order(3, 30, order(TURN_1, 30), told)
    with pytest.raises(Breach, match="F2"):
        judge_order(1, 10, order(TURN_1, 10), TURN_1)
    with pytest.raises(Breach, match="F2"):
        judge_order(3, 31, order(TURN_1, 30), TURN_1)


FORMED = StrandFormed(
    epoch=VIEW.epoch.number,
    turn=3,
    order=(1, 2),
    lives=("a", "14"),
    places_m=(1.0, 0.0),
    laid=(Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0)),
    driven=(False, False),
    back_by_m=0.0,
    sensed=False,
)


def poses(x_m: float) -> list[Pose]:
    return [Pose(x_m=x_m, y_m=0.0, heading_rad=0.0), Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)]


def test_members_stand_where_the_formation_says() -> None:
    judge_places(ALL, FORMED, poses(1.009), 0.01)
    with pytest.raises(Breach, match="robot 1 stands"):
        judge_places(ALL, FORMED, poses(1.02), 0.01)
    with pytest.raises(Breach, match="F4"):
        judge_places(ALL, None, poses(1.0), 0.01)


def test_only_members_drive_in_the_lives_that_the_formation_names() -> None:
    judge_member(1, order(ALL, 10), FORMED)
    for robot, life in ((1, 11), (3, 30)):
        with pytest.raises(Breach, match="F4"):
            judge_member(robot, order(ALL, life), FORMED)


def test_a_plan_rests_on_a_scan_of_the_fence_that_is_told() -> None:
    def scan(fence: Fence) -> Scan:
        return Scan(t_s=0.0, pose=poses(0.0)[0], fence=fence, ranges_m=(1.0,) * 8)

    judge_plan(3, scan(TURN_1), TURN_1)
    first = Fence(epoch=VIEW.epoch, turn=1, may=May.ALL, robot=1, members=2)
    for seen, told in ((VIEW, TURN_1), (TURN_1, ALL), (VIEW, ALL), (FIRST, VIEW), (VIEW, first)):
        with pytest.raises(Breach, match="F6"):
            judge_plan(3, scan(seen), told)
    with pytest.raises(Breach, match="F6"):
        judge_plan(3, None, TURN_1)
