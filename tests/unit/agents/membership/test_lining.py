"""Lining up as a conversation: what one robot says, and a whole fleet over a network that loses messages."""

from collections.abc import Mapping

import pytest
from agents.membership.berth import Berth
from agents.membership.giving import MAKES_WAY_S
from agents.membership.lining import Lining
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.body.driver import Driver
from protocol.frames import Point, Pose
from protocol.mission import Mission
from protocol.path import Path
from protocol.wire.messages import Attempt, Muster, Odometry, Phase, Turn
from tests.support.stages.lining_stage import (
    BOX,
    EPOCH,
    GOAL,
    PLACES,
    RADIUS_M,
    announced,
    at,
    called,
    mission,
    says,
    says_of_call,
    scan_of,
    wants_scan,
)
from tests.support.stages.one_step import look_around
from world.geometry.shapes import Circle


@pytest.mark.parametrize(("robots", "again_s"), [(2, 0.1), (10, 0.1), (20, 0.2), (100, 0.25), (1000, 0.25)])
def test_a_robot_says_where_it_stands_at_once_and_again_as_often_as_all_can_hear(
    robots: int, again_s: float
) -> None:
    lining = Lining(1, mission(robots=robots, goal=GOAL))
    tried_s = (0.0, again_s - 0.01, again_s, 2.0 * again_s - 0.01, 2.0 * again_s)
    said = [says(lining, PLACES[1], None, now_s) for now_s in tried_s]
    assert said == [[at(1, 1)], [], [at(1, 2, t_s=again_s)], [], [at(1, 3, t_s=2.0 * again_s)]]


def test_with_a_goal_the_leader_does_not_sense() -> None:
    lining = Lining(1, mission(robots=1, goal=GOAL))
    says(lining, PLACES[1], None, 0.0)
    assert not wants_scan(lining, PLACES[1])
    assert lining.may_lead


def test_with_a_goal_who_follows_looks_at_its_leg_once_and_says_at_once_what_it_saw() -> None:
    fleet = mission(robots=2, goal=GOAL)
    lining = Lining(1, fleet)
    says(lining, PLACES[1], None, 0.0)
    wanted = [wants_scan(lining, PLACES[1])]
    lining.hear(2, at(2), 0.0)
    wanted.append(wants_scan(lining, PLACES[1]))
    (muster,) = says(lining, PLACES[1], scan_of(1, fleet), 0.1)
    wanted.append(wants_scan(lining, PLACES[1]))
    assert wanted == [False, True, False]
    assert muster.leg_clear is True


@pytest.mark.parametrize(("far_m", "clear"), [(0.9, True), (1.1, False)])
def test_a_leg_is_not_clear_if_it_is_longer_than_a_link_may_be(far_m: float, clear: bool) -> None:
    fleet = mission(robots=2, goal=GOAL)
    places = {1: PLACES[1], 2: Pose(x_m=1.0 + far_m, y_m=0.0, heading_rad=0.0)}
    lining = Lining(1, fleet)
    lining.hear(2, Muster(number=1, pose=places[2]), 0.0)
    says(lining, PLACES[1], None, 0.0)
    (muster,) = says(lining, PLACES[1], scan_of(1, fleet, places), 0.1)
    assert muster.leg_clear is clear


def test_a_leg_through_an_obstacle_is_not_clear() -> None:
    fleet = mission(robots=2, goal=GOAL)
    lining = Lining(1, fleet)
    lining.hear(2, at(2), 0.0)
    says(lining, PLACES[1], None, 0.0)
    post = Circle(centre_m=(1.5, 0.1), radius_m=0.05)
    (muster,) = says(lining, PLACES[1], look_around([*BOX, post], fleet, PLACES[1]), 0.1)
    assert muster.leg_clear is False


def test_without_a_goal_it_senses_once_all_places_are_known_and_only_once() -> None:
    fleet = mission(robots=2, goal=None)
    lining = Lining(1, fleet)
    says(lining, PLACES[1], None, 0.0)
    wanted = [wants_scan(lining, PLACES[1])]
    lining.hear(2, at(2), 0.0)
    wanted.append(wants_scan(lining, PLACES[1]))
    (muster,) = says(lining, PLACES[1], scan_of(1, fleet), 0.1)
    lining.hear(2, Muster(number=2, pose=PLACES[2], obstacle_m=0.1), 0.2)
    (then,) = says(lining, PLACES[1], None, 0.2)
    wanted.append(wants_scan(lining, PLACES[1]))
    assert wanted == [False, True, False]
    assert (muster.obstacle_m is not None, muster.leg_clear, then.leg_clear) == (True, None, True)


def test_a_scan_that_comes_before_all_places_are_known_is_not_believed() -> None:
    fleet = mission(robots=2, goal=None)
    lining = Lining(1, fleet)
    (muster,) = says(lining, PLACES[1], scan_of(1, fleet), 0.0)
    assert muster.obstacle_m is None


def test_another_robot_is_no_obstacle() -> None:
    fleet = mission(robots=3, goal=None)
    lining = Lining(2, fleet)
    for other in (1, 3):
        lining.hear(other, at(other), 0.0)
    (muster,) = says(lining, PLACES[2], scan_of(2, fleet), 0.0)
    assert muster.obstacle_m == pytest.approx((2.0**2 + 2.0**2) ** 0.5 - 0.5, abs=0.01)


def test_an_obstacle_that_almost_touches_the_robot_is_an_obstacle() -> None:
    fleet = mission(robots=1, goal=None)
    lining, beside = Lining(1, fleet), Pose(x_m=0.0, y_m=1.5 - RADIUS_M - fleet.mu0_m, heading_rad=0.0)
    says(lining, beside, None, 0.0)
    (muster,) = says(lining, beside, look_around(BOX, fleet, beside), 0.1)
    assert muster.obstacle_m == pytest.approx(RADIUS_M + fleet.mu0_m, abs=0.001)


def test_where_nothing_but_robots_is_in_sight_the_obstacle_is_at_the_range_limit() -> None:
    fleet = mission(robots=2, goal=None)
    far = {robot: Pose(x_m=20.0 + robot, y_m=0.0, heading_rad=0.0) for robot in (1, 2)}
    lining = Lining(1, fleet)
    lining.hear(2, Muster(number=1, pose=far[2]), 0.0)
    (muster,) = says(lining, far[1], scan_of(1, fleet, far), 0.0)
    assert muster.obstacle_m == fleet.range_m_max


def test_a_robot_is_not_told_by_others_where_it_stands() -> None:
    lining = Lining(1, mission(robots=1, goal=GOAL))
    lining.hear(1, Muster(number=9, pose=Pose(x_m=GOAL.x_m, y_m=GOAL.y_m, heading_rad=0.0)), 0.0)
    (muster,) = says(lining, PLACES[1], None, 0.0)
    assert muster.pose == PLACES[1]


def converse(linings: Mapping[int, Lining], fleet: Mission, now_s: float, lost: set[tuple[int, int]]) -> None:
    """One heartbeat: all announce, and all but the lost announcements are heard."""
    for sender, lining in linings.items():
        scan = scan_of(sender, fleet) if wants_scan(lining, PLACES[sender]) else None
        for muster in says(lining, PLACES[sender], scan, now_s):
            for receiver in linings:
                if receiver != sender and (sender, receiver) not in lost:
                    linings[receiver].hear(sender, muster, now_s)


@pytest.mark.parametrize(("goal", "order"), [(None, (1, 2, 3)), (GOAL, (3, 2, 1))])
@given(lossy=st.lists(st.sets(st.tuples(st.sampled_from([1, 2, 3]), st.sampled_from([1, 2, 3]))), max_size=5))
def test_whatever_is_lost_at_first_all_agree_in_the_end_and_one_leads(
    goal: Point | None, order: tuple[int, ...], lossy: list[set[tuple[int, int]]]
) -> None:
    fleet = mission(robots=3, goal=goal)
    linings = {robot: Lining(robot, fleet) for robot in PLACES}
    for beat, lost in enumerate([*lossy, *(set[tuple[int, int]]() for _ in range(7))]):
        converse(linings, fleet, beat * fleet.heartbeat_s, lost)
    assert {lining.order for lining in linings.values()} == {order}
    assert [robot for robot, lining in linings.items() if lining.may_lead] == [order[0]]


# --- an epoch that was called -----------------------------------------------------------------------


def test_an_announcement_names_the_epoch_the_members_and_whom_it_has_heard() -> None:
    lining = called(members=(1, 2, 3))
    (first,) = says(lining, PLACES[1], None, 5.0)
    lining.hear(3, says_of_call(3), 5.1)
    (then,) = says(lining, PLACES[1], None, 5.1)
    assert [(said.epoch, said.members) for said in (first, then)] == [(EPOCH, (1, 2, 3))] * 2
    assert then.hears == (1, 3)


def test_nobody_announces_itself_in_a_call_before_it_stands() -> None:
    lining, driver = called(members=(1, 2, 3)), Driver(speed_mps=0.3)
    moving = Odometry(t_s=5.0, pose=PLACES[1], moving=True, finished=0, phase=Phase.RUNNING, ordered=7)
    driver.hear(moving)
    driver.start_again()
    said = [announced(lining.act(driver, None, 5.0))]
    driver.hear(replace(moving, moving=False, ordered=driver.drive.number, finished=driver.drive.number))
    said.append(announced(lining.act(driver, None, 5.1)))
    assert [len(each) for each in said] == [0, 1]


def test_all_are_bound_when_all_members_have_been_heard_and_nobody_else_is_waited_for() -> None:
    lining = called(members=(1, 3))
    bound = [lining.all_are_bound]
    says(lining, PLACES[1], None, 5.0)
    bound.append(lining.all_are_bound)
    lining.hear(2, says_of_call(2), 5.1)
    bound.append(lining.all_are_bound)
    lining.hear(3, replace(says_of_call(3), members=(1, 3)), 5.2)
    bound.append(lining.all_are_bound)
    assert bound == [False, False, False, True]


def test_an_announcement_that_names_other_members_is_void_though_it_is_of_the_same_epoch() -> None:
    lining = called(members=(1, 3))
    says(lining, PLACES[1], None, 5.0)
    lining.hear(3, says_of_call(3), 5.1)
    assert not lining.all_are_bound
    assert lining.heard_at_s(3) == lining.began_s


def test_who_is_shunned_is_not_heard() -> None:
    lining = called(members=(1, 2, 3), shunned=frozenset({2}))
    lining.hear(2, says_of_call(2), 5.1)
    assert lining.heard_at_s(2) == lining.began_s == 5.0


def test_who_has_been_heard_by_whom_shows_which_two_do_not_hear_each_other() -> None:
    lining = called(members=(1, 2, 3))
    says(lining, PLACES[1], None, 5.0)
    lining.hear(2, says_of_call(2, hears=(1, 2)), 5.1)
    lining.hear(3, says_of_call(3, hears=(1, 2, 3)), 5.1)
    says(lining, PLACES[1], None, 5.2)
    assert lining.unheard_pairs() == {(2, 3)}


def test_a_robot_knows_its_own_place_before_it_reckons_the_order() -> None:
    path, here = (
        Path([Point(x_m=4.0, y_m=0.0), Point(x_m=5.0, y_m=0.0)]),
        Pose(x_m=5.0, y_m=0.0, heading_rad=0.0),
    )
    others = {2: Pose(x_m=1.0, y_m=3.0, heading_rad=0.0), 3: Pose(x_m=5.5, y_m=1.0, heading_rad=0.0)}
    fleet, berth = mission(robots=3, goal=GOAL), Berth(1, 0, 1.0, path, speed_mps=0.3)
    lining = Lining(
        1, fleet, 5.0, epoch=EPOCH, members=(1, 2, 3), berths=(berth,), attempt=Attempt(trial=False)
    )
    for robot, pose in others.items():
        lining.hear(robot, says_of_call(robot, pose=pose, leg_clear=True), 5.0)
    says(lining, here, None, 5.1)
    assert lining.order == (1, 3, 2), "the next is the nearest to where it stands"


# --- nobody finds a way to a place ------------------------------------------------------------------


def alone_in_place(*, members: tuple[int, ...] = (1, 2)) -> Lining:
    """Robot 1 of three, which leads; robot 2 has had its turn in vain."""
    fleet = mission(robots=3, goal=Point(x_m=-9.0, y_m=0.0))
    lining = Lining(1, fleet, 5.0, epoch=EPOCH, members=members)
    says(lining, PLACES[1], None, 5.0)
    in_vain = {"members": members, "leg_clear": False}
    for robot in members[1:]:
        lining.hear(robot, replace(says_of_call(robot), **in_vain), 5.0)
    for number, robot in enumerate(members[1:], start=2):
        (given,) = says(lining, PLACES[1], None, 5.0 + number / 10.0)
        assert given.gives == Turn(number=number - 1, robot=robot)
        said = replace(says_of_call(robot, number), ended=number - 1, turn=number - 1, **in_vain)
        lining.hear(robot, said, 5.0 + number / 10.0)
    return lining


def gives_itself_a_turn(lining: Lining, now_s: float) -> bool:
    """Whether robot 1 has given itself one by then."""
    given = [said.gives for said in says(lining, PLACES[1], None, now_s)]
    assert given, "asked between heartbeats"
    return given[0] is not None and given[0].robot == 1


def test_a_leader_to_which_nobody_finds_a_way_gives_itself_a_turn_to_get_clear() -> None:
    assert gives_itself_a_turn(alone_in_place(members=(1, 2, 3)), 6.0)


def test_where_somebody_is_left_out_who_may_stand_in_the_way_the_leader_first_waits_for_that_one() -> None:
    lining = alone_in_place()
    turns = [gives_itself_a_turn(lining, 6.0 + wait_s) for wait_s in (0.0, MAKES_WAY_S - 0.5, MAKES_WAY_S)]
    assert turns == [False, False, True]
    assert lining.stuck_at_s == 6.0


def test_who_has_gone_for_long_is_not_waited_for() -> None:
    lining = alone_in_place()
    lining.others_may_come_back = False
    assert gives_itself_a_turn(lining, 6.0)
