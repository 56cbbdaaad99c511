"""Lining up as a conversation: what one robot says, and a whole fleet over a network that loses messages."""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.berth import Berth
from agents.commands import Announce, Command
from agents.driver import Driver
from agents.giving import MAKES_WAY_S
from agents.lining import Lining
from agents.scan import View
from protocol.epochs import called_epoch
from protocol.frames import Point, Pose
from protocol.messages import Attempt, Muster, Odometry, Phase, Turn
from protocol.mission import Law, Mission
from protocol.path import Path
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


def standing_at(pose: Pose) -> Driver:
    driver = Driver(speed_mps=0.3)
    driver.hear(Odometry(t_s=0.0, pose=pose, moving=False, finished=0, phase=Phase.RUNNING))
    return driver


def announced(commands: list[Command]) -> list[Muster]:
    said = [command.muster for command in commands if isinstance(command, Announce)]
    return [each for each in said if isinstance(each, Muster)]


def says(lining: Lining, pose: Pose, scan: View | None, now_s: float) -> list[Muster]:
    return announced(lining.act(standing_at(pose), scan, now_s))


def at(robot: int, number: int = 1, *, t_s: float = 0.0) -> Muster:
    return Muster(number=number, pose=PLACES[robot], t_s=t_s)


def wants_scan(lining: Lining, pose: Pose) -> bool:
    return lining.wants_scan(standing_at(pose))


def test_a_robot_says_where_it_stands_at_once_and_again_on_every_heartbeat() -> None:
    lining = Lining(1, mission(robots=2, goal=GOAL))
    said = [says(lining, PLACES[1], None, now_s) for now_s in (0.0, 0.1, 0.2, 0.25, 0.3, 0.5)]
    assert said == [[at(1, 1)], [], [], [at(1, 2, t_s=0.25)], [], [at(1, 3, t_s=0.5)]]


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

EPOCH = called_epoch(0, 1, 5.0)
TURN = Turn(number=1, robot=2)


def called(*, members: tuple[int, ...], shunned: frozenset[int] = frozenset()) -> Lining:
    return Lining(1, mission(robots=3, goal=GOAL), 5.0, epoch=EPOCH, members=members, shunned=shunned)


def says_of_call(robot: int, number: int = 1, **news: object) -> Muster:
    return replace(at(robot, number), epoch=EPOCH, members=(1, 2, 3), **news)


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


def in_turn() -> Lining:
    """Robot 2, which has the turn to join robot 1; all others say that they stand in it."""
    fleet = mission(robots=3, goal=Point(x_m=-9.0, y_m=0.0))
    lining = Lining(2, fleet, 5.0, epoch=EPOCH, members=(1, 2, 3))
    says(lining, PLACES[2], None, 5.0)
    for robot in (1, 3):
        lining.hear(robot, says_of_call(robot, leg_clear=robot == 1), 5.1)
    post = Circle(centre_m=(1.5, 0.1), radius_m=0.05)
    says(lining, PLACES[2], look_around([*BOX, post], fleet, PLACES[2]), 5.2)
    gives = {"turn": 1, "echo_s": 5.2}
    lining.hear(1, says_of_call(1, 2, leg_clear=True, gives=TURN, **gives), 5.3)
    lining.hear(3, says_of_call(3, 2, leg_clear=False, **gives), 5.3)
    return lining


def looks_to_drive(lining: Lining, now_s: float) -> bool:
    says(lining, PLACES[2], None, now_s)
    return wants_scan(lining, PLACES[2])


def test_nobody_drives_before_whoever_is_left_out_must_stand() -> None:
    lining = in_turn()
    drives = [looks_to_drive(lining, 5.4)]
    lining.free_at_s = 5.6
    drives += [looks_to_drive(lining, now_s) for now_s in (5.5, 5.7)]
    assert drives == [False, False, True]


def test_nobody_joins_by_a_scan_from_before_whoever_is_left_out_must_stand() -> None:
    lining = in_turn()
    lining.free_at_s = 5.6
    seen = look_around(BOX, mission(robots=3, goal=GOAL), PLACES[2])
    ranks = []
    for taken_s in (5.5, 5.6):
        said = says(lining, PLACES[2], dataclasses.replace(seen, t_s=taken_s), 5.2 + taken_s / 10.0)
        ranks.append([muster.rank for muster in said])
    assert ranks == [[None], [1]]


def test_who_has_had_its_turn_in_vain_finds_no_way() -> None:
    lining = in_turn()
    lining.free_at_s = 5.2
    found = [lining.finds_no_way]
    posts: list[Shape] = [
        Circle(centre_m=(2.0 + 0.5 * math.cos(angle), 0.5 * math.sin(angle)), radius_m=0.15)
        for angle in np.linspace(0.0, 2.0 * math.pi, 12)
    ]
    shut_in = look_around(posts, mission(robots=3, goal=GOAL), PLACES[2])
    said = says(lining, PLACES[2], dataclasses.replace(shut_in, t_s=5.3), 5.3)
    found.append(lining.finds_no_way)
    assert [(muster.ended, muster.rank) for muster in said] == [(1, None)]
    assert found == [False, True]


def test_who_has_the_turn_drives_only_while_all_others_echo_what_it_said_of_late() -> None:
    lining = in_turn()
    lining.free_at_s = 5.0
    silence_s = mission(robots=3, goal=None).silence_s
    drives = [looks_to_drive(lining, 5.2 + silence_s - 0.1), looks_to_drive(lining, 5.2 + silence_s + 0.1)]
    lining.hear(1, says_of_call(1, 3, leg_clear=True, gives=TURN, turn=1, echo_s=6.2), 6.3)
    drives.append(looks_to_drive(lining, 6.4))
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=6.2), 6.4)
    drives.append(looks_to_drive(lining, 6.5))
    assert drives == [True, False, False, True]


def test_an_echo_of_what_is_yet_to_be_said_is_no_answer_to_who_has_the_turn() -> None:
    lining = in_turn()
    lining.free_at_s = 5.0
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=9.0), 5.4)
    drives = [looks_to_drive(lining, 5.5)]
    lining.hear(3, says_of_call(3, 4, leg_clear=False, turn=1, echo_s=5.4), 5.6)
    drives.append(looks_to_drive(lining, 5.7))
    assert drives == [False, True]


def third(*, echo_s: float, now_s: float, mover_t_s: float = 0.0, in_turn: int = 1) -> float:
    """What robot 3 echoes while robot 2 has turn 1, when robot 1 has echoed so much in some turn."""
    lining = Lining(3, mission(robots=3, goal=GOAL), 5.0, epoch=EPOCH, members=(1, 2, 3))
    says(lining, PLACES[3], None, 5.0)
    lining.hear(2, says_of_call(2, turn=1, t_s=mover_t_s), 5.1)
    lining.hear(1, says_of_call(1, gives=TURN, turn=in_turn, echo_s=echo_s), 5.1)
    return says(lining, PLACES[3], None, now_s)[-1].echo_s


def test_what_a_robot_has_not_heard_itself_it_echoes_where_another_has_heard_it() -> None:
    assert third(mover_t_s=5.0, echo_s=6.0, now_s=6.1) == 6.0
    assert third(mover_t_s=6.0, echo_s=5.0, now_s=6.1) == 6.0


def test_who_misses_odometry_too_echoes_what_another_has_heard_by_a_clock_a_little_ahead() -> None:
    assert third(mover_t_s=5.0, echo_s=6.5, now_s=6.1) == 6.5


def test_an_echo_of_whoever_had_the_turn_before_is_not_passed_on() -> None:
    assert third(mover_t_s=5.0, echo_s=6.0, now_s=6.1, in_turn=0) == 5.0


def test_an_echo_that_no_clock_can_account_for_is_not_passed_on() -> None:
    assert third(mover_t_s=5.0, echo_s=60.0, now_s=6.1) == 5.0


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
