"""How long a step is kept while the scans do not permit the body to move."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import APPROACH_S, LONGEST_S, STILL_S_MAX, Watch, good_for_s
from protocol.fence import Fence
from protocol.frames import Point, Pose
from protocol.mission import BRIEF_S, MOVES_S
from protocol.wire.messages import Odometry, Phase
from tests.support.stages.one_step import look_around, under
from world.geometry.clearance import clearance
from world.geometry.shapes import Circle, ground_of

MISSION = replace(under("certified", robots=2, robot_radius_m=0.1), obstacle_speed_mps_max=0.5)
AHEAD = Point(x_m=2.0, y_m=0.0)
TICK_S = 0.1


class Body:
    """A robot's body whose order and place the test sets; time passes in tenths of a second."""

    def __init__(self) -> None:
        self.driver = Driver(speed_mps=MISSION.speed_mps, watched=True)
        self.watch = Watch(MISSION, self.driver, Senses(MISSION, self.driver))
        self.now_s, self.x_m, self._told = 0.0, 0.0, 0
        self.wait(TICK_S)

    def wait(self, for_s: float, *, speed_mps: float = 0.0) -> bool:
        """Let time pass; returns whether to give up the current step then."""
        for _ in range(round(for_s / TICK_S)):
            self.now_s += TICK_S
            self.x_m += speed_mps * TICK_S
            drive = self.driver.drive
            finished = drive.number if drive.target is None else drive.number - 1
            pose = Pose(x_m=self.x_m, y_m=0.0, heading_rad=0.0)
            self._told += 1
            told = Odometry(
                n=self._told,
                t_s=self.now_s,
                pose=pose,
                moving=False,
                finished=finished,
                fence=Fence(),
                phase=Phase.RUNNING,
            )
            self.driver.hear(told)
            self.watch.look(self.now_s)
        return self.gives_up()

    def gives_up(self) -> bool:
        if gives_up := self.watch.gives_up(self.now_s):
            self.watch.begin_again()
        return gives_up

    def go(self) -> None:
        self.driver.to(AHEAD, reach_m=2.0)


def test_a_step_is_given_up_when_the_body_has_not_moved_for_the_limit() -> None:
    body = Body()
    body.go()
    assert [body.wait(STILL_S_MAX), body.wait(0.3)] == [False, True]


def test_the_limit_starts_again_when_the_body_moves() -> None:
    body = Body()
    body.go()
    assert not body.wait(STILL_S_MAX - 1.0)
    assert not body.wait(1.0, speed_mps=0.1)
    assert not body.wait(STILL_S_MAX - 1.0)


def test_standing_by_order_neither_counts_nor_resets_the_limit() -> None:
    body = Body()
    body.go()
    assert not body.wait(STILL_S_MAX - 2.0)
    body.driver.stand()
    assert not body.wait(5.0)
    body.go()
    assert [body.wait(1.5), body.wait(1.0)] == [False, True]


# --- how long a motion is safe ---------------------------------------------------------------------

RUNNER = replace(MISSION, obstacle_speed_mps_max=2.5)
TARGET = np.array([2.0, 0.0])
HULL_M = RUNNER.robot_radius_m + RUNNER.mu0_m
MOMENT_M = BRIEF_S * RUNNER.obstacle_speed_mps_max
MOVES_M = MOVES_S * RUNNER.obstacle_speed_mps_max


def post(off_m: float) -> Circle:
    """Something round, so far beside the robot."""
    return Circle(centre_m=(0.0, off_m + 0.1), radius_m=0.1)


def good_s(x_m: float, y_m: float) -> float:
    """How long the way is safe beside somebody there."""
    somebody = Circle(centre_m=(x_m, y_m), radius_m=0.25)
    return good_for_s(look_around([somebody], RUNNER), TARGET, RUNNER)


def test_a_permission_lasts_for_two_ticks_of_the_world_or_there_is_none() -> None:
    """In one tick the order comes, and in the next one the body moves."""
    away, offs_m = np.array([0.0, -2.0]), np.arange(0.115, 0.145, 0.001).tolist()
    goods_s = [good_for_s(look_around([post(off_m)], MISSION), away, MISSION) for off_m in offs_m]
    assert goods_s == sorted(goods_s)
    assert goods_s[0] == 0.0
    assert 0.04 <= min(good for good in goods_s if good > 0.0) < 0.05


@pytest.mark.parametrize("x_m", [-0.1, 0.0, 0.1, 0.3])
def test_somebody_beside_the_way_is_passed_by_moments(x_m: float) -> None:
    good = good_s(x_m, 0.25 + HULL_M + MOMENT_M + 0.02)
    assert BRIEF_S <= good < APPROACH_S


@pytest.mark.parametrize("x_m", [0.1, 0.3, 0.5])
def test_a_robot_that_leaves_no_moment_somewhere_on_the_way_is_not_approached(x_m: float) -> None:
    assert good_s(x_m, 0.25 + HULL_M + MOVES_M - 0.02) == 0.0


@pytest.mark.parametrize("x_m", [0.1, 0.3, 0.5])
def test_what_was_planned_for_a_moment_is_approached_though_it_is_seen_a_little_nearer(x_m: float) -> None:
    assert good_s(x_m, 0.25 + HULL_M + MOMENT_M - 0.005) > 0.0


@given(st.floats(-0.5, 1.5), st.floats(0.0, 1.5))
def test_within_the_time_nobody_can_touch_the_moving_hull(x_m: float, y_m: float) -> None:
    good = good_s(x_m, y_m + 0.36)
    ground = ground_of([Circle(centre_m=(x_m, y_m + 0.36), radius_m=0.25)])
    driven = np.array([[min(RUNNER.speed_mps * good, 2.0), 0.0]])
    apart_m = float(clearance(ground, np.zeros((1, 2)), driven)[0]) - RUNNER.robot_radius_m
    assert good == 0.0 or apart_m > RUNNER.obstacle_speed_mps_max * good


@given(st.floats(0.31, 0.6), st.floats(-np.pi, np.pi), st.floats(0.2, 0.5), st.floats(-0.5, 0.5))
def test_nor_who_is_hidden_behind_a_robot(off_m: float, bearing: float, behind_m: float, turn: float) -> None:
    """M4 of docs/fleets.md: any robot near by, and anybody behind it."""
    hulls, at = [], np.zeros(2)
    for way_m, heading in ((off_m, bearing), (behind_m, bearing + turn)):
        at = at + way_m * np.array([np.cos(heading), np.sin(heading)])
        hulls.append(Circle(centre_m=(float(at[0]), float(at[1])), radius_m=MISSION.robot_radius_m))
    good = good_for_s(look_around(hulls, MISSION), TARGET, MISSION)
    driven = np.array([[min(MISSION.speed_mps * good, 2.0), 0.0]])
    apart_m = float(clearance(ground_of(hulls), np.zeros((1, 2)), driven)[0]) - MISSION.robot_radius_m
    assert good == 0.0 or apart_m > MISSION.obstacle_speed_mps_max * good


@pytest.mark.parametrize("off_m", [0.6, 0.7, 0.9, 1.2, 1.6])
def test_two_that_drive_towards_each_other_until_their_permissions_end_may_both_move_again(
    off_m: float,
) -> None:
    """Whatever scans are lost meanwhile: nearer than a moment, neither could get away from the other."""
    gap_m = off_m - 0.25 - HULL_M - BRIEF_S * MISSION.obstacle_speed_mps_max
    until_s = min(gap_m / (MISSION.speed_mps + MISSION.obstacle_speed_mps_max), LONGEST_S)
    somebody = Circle(centre_m=(off_m, 0.0), radius_m=0.25)
    good = good_for_s(look_around([somebody], MISSION), TARGET, MISSION)
    assert 0.0 <= until_s - good < 0.02
    met = Circle(centre_m=(off_m - 2.0 * MISSION.speed_mps * good, 0.0), radius_m=0.25)
    assert good_for_s(look_around([met], MISSION), -TARGET, MISSION) > 0.0
