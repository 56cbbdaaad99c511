"""Lining up as a conversation: what one robot says, and a whole fleet over a network that loses messages."""

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.commands import Announce, Command
from agents.lining import Lining
from agents.scan import View
from protocol.frames import Point, Pose
from protocol.messages import Muster
from protocol.mission import Law, Mission
from tests.one_step import look_around, under
from world.shapes import Circle, Shape

RADIUS_M = 0.1
BOX: list[Shape] = [Circle(centre_m=(0.0, 2.0), radius_m=0.5)]
GOAL = Point(x_m=9.0, y_m=0.0)
PLACES = {robot: Pose(x_m=float(robot), y_m=0.0, heading_rad=0.0) for robot in (1, 2, 3)}


def mission(*, robots: int, goal: Point | None) -> Mission:
    return under(Law.CERTIFIED, robots=robots, robot_radius_m=RADIUS_M, goal=goal, directions=360)


def scan_of(robot: int, fleet: Mission, places: Mapping[int, Pose] = PLACES) -> View:
    """What the robot sees: the box, and the other robots' hulls."""
    hulls: list[Shape] = [
        Circle(centre_m=(pose.x_m, pose.y_m), radius_m=RADIUS_M)
        for other, pose in places.items()
        if other != robot
    ]
    return look_around(BOX + hulls, fleet, places[robot])


def announced(commands: list[Command]) -> list[Muster]:
    return [command.muster for command in commands if isinstance(command, Announce)]


def test_a_robot_says_where_it_stands_at_once_and_again_on_every_heartbeat() -> None:
    lining = Lining(1, mission(robots=2, goal=GOAL))
    said = [announced(lining.announce(PLACES[1], None, now_s)) for now_s in (0.0, 0.1, 0.2, 0.25, 0.3, 0.5)]
    muster = Muster(pose=PLACES[1], obstacle_m=None, order=())
    assert said == [[muster], [], [], [muster], [], [muster]]


def test_what_it_has_learnt_it_says_at_once() -> None:
    lining = Lining(1, mission(robots=2, goal=GOAL))
    lining.announce(PLACES[1], None, 0.0)
    lining.hear(2, Muster(pose=PLACES[2], obstacle_m=None, order=()))
    assert announced(lining.announce(PLACES[1], None, 0.1)) == [
        Muster(pose=PLACES[1], obstacle_m=None, order=(2, 1))
    ]


def test_with_a_goal_nobody_senses() -> None:
    lining = Lining(1, mission(robots=1, goal=GOAL))
    lining.announce(PLACES[1], None, 0.0)
    assert not lining.wants_scan
    assert lining.may_lead


def test_without_a_goal_it_senses_once_all_places_are_known_and_only_once() -> None:
    fleet = mission(robots=2, goal=None)
    lining = Lining(1, fleet)
    lining.announce(PLACES[1], None, 0.0)
    wanted = [lining.wants_scan]
    lining.hear(2, Muster(pose=PLACES[2], obstacle_m=None, order=()))
    wanted.append(lining.wants_scan)
    (muster,) = announced(lining.announce(PLACES[1], scan_of(1, fleet), 0.1))
    wanted.append(lining.wants_scan)
    assert wanted == [False, True, False]
    assert muster.obstacle_m is not None


def test_a_scan_that_comes_before_all_places_are_known_is_not_believed() -> None:
    fleet = mission(robots=2, goal=None)
    lining = Lining(1, fleet)
    (muster,) = announced(lining.announce(PLACES[1], scan_of(1, fleet), 0.0))
    assert muster.obstacle_m is None


def test_another_robot_is_no_obstacle() -> None:
    fleet = mission(robots=3, goal=None)
    lining = Lining(2, fleet)
    for other in (1, 3):
        lining.hear(other, Muster(pose=PLACES[other], obstacle_m=None, order=()))
    (muster,) = announced(lining.announce(PLACES[2], scan_of(2, fleet), 0.0))
    assert muster.obstacle_m == pytest.approx((2.0**2 + 2.0**2) ** 0.5 - 0.5, abs=0.01)


def test_an_obstacle_that_almost_touches_the_robot_is_an_obstacle() -> None:
    fleet = mission(robots=1, goal=None)
    lining, beside = Lining(1, fleet), Pose(x_m=0.0, y_m=1.5 - RADIUS_M - fleet.mu0_m, heading_rad=0.0)
    lining.announce(beside, None, 0.0)
    (muster,) = announced(lining.announce(beside, look_around(BOX, fleet, beside), 0.1))
    assert muster.obstacle_m == pytest.approx(RADIUS_M + fleet.mu0_m, abs=0.001)


def test_where_nothing_but_robots_is_in_sight_the_obstacle_is_at_the_range_limit() -> None:
    fleet = mission(robots=2, goal=None)
    far = {robot: Pose(x_m=20.0 + robot, y_m=0.0, heading_rad=0.0) for robot in (1, 2)}
    lining = Lining(1, fleet)
    lining.hear(2, Muster(pose=far[2], obstacle_m=None, order=()))
    (muster,) = announced(lining.announce(far[1], scan_of(1, fleet, far), 0.0))
    assert muster.obstacle_m == fleet.range_m_max


def test_a_robot_is_not_told_by_others_where_it_stands() -> None:
    lining = Lining(1, mission(robots=2, goal=GOAL))
    at_the_goal = Pose(x_m=GOAL.x_m, y_m=GOAL.y_m, heading_rad=0.0)
    lining.hear(1, Muster(pose=at_the_goal, obstacle_m=None, order=(1, 2)))
    lining.hear(2, Muster(pose=PLACES[2], obstacle_m=None, order=()))
    (muster,) = announced(lining.announce(PLACES[1], None, 0.0))
    assert muster.order == (2, 1)


def converse(linings: Mapping[int, Lining], fleet: Mission, now_s: float, lost: set[tuple[int, int]]) -> None:
    """One heartbeat: all announce, and all but the lost announcements are heard."""
    for sender, lining in linings.items():
        scan = scan_of(sender, fleet) if lining.wants_scan else None
        for muster in announced(lining.announce(PLACES[sender], scan, now_s)):
            for receiver in linings:
                if receiver != sender and (sender, receiver) not in lost:
                    linings[receiver].hear(sender, muster)


@pytest.mark.parametrize(("goal", "order"), [(None, (1, 2, 3)), (GOAL, (3, 2, 1))])
@given(lossy=st.lists(st.sets(st.tuples(st.sampled_from([1, 2, 3]), st.sampled_from([1, 2, 3]))), max_size=5))
def test_whatever_is_lost_at_first_all_agree_in_the_end_and_one_leads(
    goal: Point | None, order: tuple[int, ...], lossy: list[set[tuple[int, int]]]
) -> None:
    fleet = mission(robots=3, goal=goal)
    linings = {robot: Lining(robot, fleet) for robot in PLACES}
    for beat, lost in enumerate([*lossy, set(), set(), set(), set()]):
        converse(linings, fleet, beat * fleet.heartbeat_s, lost)
    assert {lining.order for lining in linings.values()} == {order}
    assert [robot for robot, lining in linings.items() if lining.may_lead] == [order[0]]
