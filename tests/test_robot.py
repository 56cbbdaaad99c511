"""One robot, event by event."""

from collections.abc import Iterable
from typing import TypeVar

import pytest
from msgspec.structs import replace

from agents.calls import SLEPT_S
from agents.commands import Announce, AskScan, Command, Note, Order, Tell
from agents.events import LinkHeard, MusterHeard, OdometryHeard, ScanHeard, TokenCame, TokenWent
from agents.presence import WORLD
from agents.robot import Robot
from agents.senses import RETRY_S
from protocol.frames import Point, Pose, Vertex
from protocol.messages import AheadState, BehindState, Drive, Muster, Odometry, Phase, Plea, Scan
from protocol.mission import Law, Mission
from protocol.timeline import (
    GoalReached,
    LinkBroken,
    LinkSilent,
    MusterCalled,
    RobotArrived,
    RobotHeld,
    RouteLost,
    SegmentChecked,
    StepPlanned,
    StrandFormed,
)
from tests.one_step import under

MISSION = under(
    Law.CERTIFIED,
    robots=2,
    robot_radius_m=0.1,
    goal=Point(x_m=5.0, y_m=0.0),
    goal_tolerance_m=0.1,
)
FRONT, BACK = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=-0.5, y_m=0.0, heading_rad=0.0)
ORDER = (1, 2)
HEARD_S = 0.05  # when a robot first hears an answer to what it has said to its neighbour

T = TypeVar("T")


def odometry(t_s: float, at: Pose, *, finished: int = 0, moving: bool = False) -> OdometryHeard:
    return OdometryHeard(Odometry(t_s=t_s, pose=at, moving=moving, finished=finished, phase=Phase.RUNNING))


def muster(at: Pose, order: tuple[int, ...] = ORDER) -> Muster:
    """An announcement; by the one that knows the order its leg is known to be clear."""
    return Muster(number=2 if order else 1, pose=at, leg_clear=True if order else None, order=order)


def empty_scan(t_s: float, at: Pose) -> ScanHeard:
    return ScanHeard(Scan(t_s=t_s, pose=at, ranges_m=(MISSION.range_m_max,) * MISSION.directions))


def scan_with_a_box_ahead(t_s: float, at: Pose) -> ScanHeard:
    ranges = [MISSION.range_m_max] * MISSION.directions
    middle = MISSION.directions // 2  # bearing 0
    ranges[middle - 20 : middle + 20] = [0.3] * 40
    return ScanHeard(Scan(t_s=t_s, pose=at, ranges_m=tuple(ranges)))


def behind(number: int, *, progress_m: float = 0.0, vertices: int = 2, echo_s: float = 0.0) -> LinkHeard:
    state = BehindState(
        epoch=1,
        echo_s=echo_s,
        vertices=vertices,
        progress_m=progress_m,
        tail_progress_m=progress_m,
        stand=True,
        pose=BACK,
    )
    return LinkHeard(2, number, state)


def ahead(number: int, *, authority_m: float, arrived: bool = False, echo_s: float = 0.0) -> LinkHeard:
    """The leader, two metres on."""
    state = AheadState(
        epoch=1,
        echo_s=echo_s,
        path_from=2,
        path=(Vertex(x_m=2.0, y_m=0.0, s_m=2.5),),
        progress_m=2.5,
        authority_m=authority_m,
        pose=Pose(x_m=2.0, y_m=0.0, heading_rad=0.0),
        arrived=arrived,
        lineage=(),
        vertices=3,
        backs_up=False,
        reversal=None,
    )
    return LinkHeard(1, number, state)


def only(kind: type[T], commands: Iterable[Command]) -> list[T]:
    """What of a kind is among commands, or among what they note."""
    things = [command.record if isinstance(command, Note) else command for command in commands]
    return [thing for thing in things if isinstance(thing, kind)]


def musters(commands: Iterable[Command]) -> list[Muster]:
    return [each.muster for each in only(Announce, commands) if isinstance(each.muster, Muster)]


def order_of(commands: Iterable[Command]) -> Drive:
    return only(Order, commands)[-1].drive


def leader(mission: Mission = MISSION) -> Robot:
    """Robot 1, which leads, and has just heard robot 2 behind it."""
    robot = Robot(1, mission)
    robot.handle(odometry(0.0, FRONT), 0.0)
    formed = robot.handle(MusterHeard(2, muster(BACK)), 0.0)
    assert only(StrandFormed, formed)[0].order == ORDER
    assert only(AskScan, robot.handle(behind(1, echo_s=HEARD_S), HEARD_S))
    return robot


def follower(authority_m: float = 2.0) -> Robot:
    """Robot 2, which follows, and has just heard robot 1 ahead of it."""
    robot, formed = takes_its_place(authority_m)
    assert only(StrandFormed, formed)
    return robot


def takes_its_place(authority_m: float = 2.0) -> tuple[Robot, list[Command]]:
    """Robot 2, which has looked at its leg and then hears robot 1 ahead of it; what it does then."""
    robot = Robot(2, MISSION)
    robot.handle(odometry(0.0, BACK), 0.0)
    assert only(AskScan, robot.handle(MusterHeard(1, muster(FRONT)), 0.0))
    robot.handle(empty_scan(0.0, BACK), 0.0)
    formed = robot.handle(ahead(1, authority_m=authority_m), 0.0)
    return robot, formed + robot.handle(ahead(2, authority_m=authority_m, echo_s=HEARD_S), HEARD_S)


# --- lining up ------------------------------------------------------------------------------------


def test_before_the_first_odometry_a_robot_says_nothing() -> None:
    assert Robot(1, MISSION).handle(MusterHeard(2, muster(BACK)), 0.0) == []


def test_it_announces_its_place_then_the_order_and_stands_meanwhile() -> None:
    robot = Robot(2, MISSION)
    first = robot.handle(odometry(0.0, BACK), 0.0)
    assert [said.pose for said in musters(first)] == [BACK]
    assert order_of(first).target is None
    looks = robot.handle(MusterHeard(1, muster(FRONT)), 0.0)
    assert only(AskScan, looks)
    second = robot.handle(empty_scan(0.0, BACK), 0.0)
    assert [said.order for said in musters(second)] == [ORDER]


def test_an_announcement_is_repeated_on_every_heartbeat() -> None:
    robot = Robot(2, MISSION)
    robot.handle(odometry(0.0, BACK), 0.0)
    assert only(Announce, robot.handle(odometry(0.1, BACK), 0.1)) == []
    assert len(only(Announce, robot.handle(odometry(0.3, BACK), 0.3))) == 1


def test_the_leader_waits_until_all_have_confirmed_the_order() -> None:
    robot = Robot(1, MISSION)
    robot.handle(odometry(0.0, FRONT), 0.0)
    assert not only(StrandFormed, robot.handle(MusterHeard(2, muster(BACK, ())), 0.0))
    assert only(StrandFormed, robot.handle(MusterHeard(2, muster(BACK)), 0.0))


# --- leading --------------------------------------------------------------------------------------


def test_the_leader_stands_until_it_has_heard_the_robot_behind() -> None:
    robot = Robot(1, MISSION)
    robot.handle(odometry(0.0, FRONT), 0.0)
    robot.handle(MusterHeard(2, muster(BACK)), 0.0)
    assert only(AskScan, robot.handle(odometry(0.1, FRONT), 0.1)) == []


def test_one_scan_makes_one_step_and_the_robot_behind_is_told_of_it() -> None:
    robot = leader()
    commands = robot.handle(empty_scan(0.1, FRONT), 0.1)
    (step,) = only(StepPlanned, commands)
    assert order_of(commands).target == step.target
    assert order_of(commands).step == step.step == 1
    (told,) = only(Tell, commands)
    assert isinstance(told.state, AheadState)
    assert told.state.path[-1].s_m == pytest.approx(0.5 + step.length_m)


def test_a_scan_from_elsewhere_is_not_used() -> None:
    assert not only(StepPlanned, leader().handle(empty_scan(0.1, BACK), 0.1))


def test_a_question_without_an_answer_is_asked_again() -> None:
    robot = leader()
    assert only(AskScan, robot.handle(odometry(0.1, FRONT), 0.1)) == []
    assert len(only(AskScan, robot.handle(odometry(0.1 + RETRY_S, FRONT), 0.1 + RETRY_S))) == 1


def test_at_the_end_of_a_step_the_leader_senses_again_and_at_the_goal_it_stops() -> None:
    robot = leader()
    step = only(StepPlanned, robot.handle(empty_scan(0.1, FRONT), 0.1))[0]
    there = Pose(x_m=step.target.x_m, y_m=step.target.y_m, heading_rad=0.0)
    for number, now_s in enumerate((3.0, 6.0, 9.0), start=2):
        robot.handle(behind(number, progress_m=3.9, vertices=3, echo_s=now_s - 0.5), now_s)
    commands = robot.handle(odometry(9.0, there, finished=1), 9.0)
    assert only(AskScan, commands)
    last = only(StepPlanned, robot.handle(empty_scan(9.1, there), 9.1))[0]
    goal = Pose(x_m=last.target.x_m, y_m=last.target.y_m, heading_rad=0.0)
    commands = robot.handle(odometry(9.2, goal, finished=2), 9.2)
    assert only(GoalReached, commands)
    assert only(RobotArrived, commands)


def test_a_leader_without_a_way_says_so_once_and_stands() -> None:
    robot = leader(replace(MISSION, law=Law.PRINTED))
    assert only(RouteLost, robot.handle(empty_scan(0.1, FRONT), 0.1))
    later = robot.handle(odometry(0.2, FRONT), 0.2)
    assert not only(RouteLost, later)
    assert not only(AskScan, later)


def test_a_leader_stops_for_a_silent_follower_and_then_goes_on_to_the_same_target() -> None:
    robot = leader()
    step = only(StepPlanned, robot.handle(empty_scan(0.1, FRONT), 0.1))[0]
    under_way = Pose(x_m=0.5, y_m=0.0, heading_rad=0.0)
    commands = robot.handle(odometry(1.2, under_way, moving=True), 1.2)
    assert only(LinkSilent, commands)[0].neighbour == 2
    assert order_of(commands).target is None
    assert order_of(robot.handle(odometry(1.3, under_way, finished=2), 1.3)).target is None
    assert only(Order, robot.handle(behind(2, echo_s=0.2), 1.3)) == [], "it does not hear this robot"
    assert order_of(robot.handle(behind(3, echo_s=1.2), 1.3)).target == step.target


def test_a_repeated_old_state_does_not_end_a_silence() -> None:
    robot = leader()
    robot.handle(empty_scan(0.1, FRONT), 0.1)
    under_way = Pose(x_m=0.5, y_m=0.0, heading_rad=0.0)
    robot.handle(odometry(1.2, under_way, moving=True), 1.2)
    robot.handle(behind(1, echo_s=1.2), 1.25)
    assert order_of(robot.handle(odometry(1.3, under_way, finished=2), 1.3)).target is None


def test_a_leader_holds_while_its_follower_is_too_far_behind_what_it_was_granted() -> None:
    robot = leader()
    robot.handle(empty_scan(0.1, FRONT), 0.1)
    far = Pose(x_m=2.0, y_m=0.0, heading_rad=0.0)
    robot.handle(behind(2, echo_s=0.8), 0.9)
    robot.handle(odometry(1.0, far, moving=True), 1.0)
    commands = robot.handle(odometry(1.1, far, moving=True), 1.1)
    assert only(RobotHeld, commands)[0].behind_m > MISSION.link_length_m_max
    assert order_of(commands).target is None


# --- a link that is dead ----------------------------------------------------------------------------

DEAD_S = HEARD_S + MISSION.silence_s + MISSION.patience_s + 0.01


def unheard(robot: Robot, until_s: float) -> None:
    """The robot hears the one behind, which does not hear it; time goes on by heartbeats."""
    for beat in range(1, int(until_s / MISSION.heartbeat_s) + 1):
        now_s = beat * MISSION.heartbeat_s
        robot.handle(odometry(now_s, FRONT), now_s)
        robot.handle(behind(1 + beat, echo_s=HEARD_S), now_s)


def connected(robot: Robot) -> Robot:
    """It sees the tokens of the world and of robot 2."""
    for source in (WORLD, 2):
        robot.handle(TokenCame(source, "a"), HEARD_S)
    return robot


def test_a_link_that_was_silent_for_too_long_is_given_up_though_it_is_heard_again_at_that_very_time() -> None:
    robot = connected(leader())
    unheard(robot, DEAD_S - 0.1)
    commands = robot.handle(behind(99, echo_s=DEAD_S - 0.01), DEAD_S)
    (broken,) = only(LinkBroken, commands)
    assert (broken.neighbour, broken.cause) == (2, "silence")
    assert not only(Tell, commands + robot.handle(behind(100, echo_s=DEAD_S), DEAD_S + 0.05))


def test_before_that_it_may_still_be_heard_again() -> None:
    robot = connected(leader())
    unheard(robot, DEAD_S - 0.1)
    assert not only(LinkBroken, robot.handle(behind(99, echo_s=DEAD_S - 0.1), DEAD_S - 0.02))
    assert not only(LinkBroken, robot.handle(odometry(DEAD_S + 0.1, FRONT), DEAD_S + 0.1))


def test_who_gives_up_a_link_calls_all_that_show_a_token() -> None:
    robot = connected(leader())
    unheard(robot, DEAD_S - 0.1)
    (call,) = only(MusterCalled, robot.handle(odometry(DEAD_S, FRONT), DEAD_S))
    assert call.members == (1, 2)


def test_who_is_cut_off_from_the_router_stands_aside_instead_and_calls_nobody() -> None:
    robot = connected(leader())
    robot.handle(TokenWent(WORLD, "a"), HEARD_S)
    unheard(robot, DEAD_S - 0.1)
    commands = robot.handle(odometry(DEAD_S, FRONT), DEAD_S)
    assert only(LinkBroken, commands)
    assert not only(MusterCalled, commands)
    later = robot.handle(odometry(DEAD_S + 1.0, FRONT), DEAD_S + 1.0)
    assert [type(said.muster) for said in only(Announce, later)] == [Plea]


def test_who_has_slept_through_a_silence_stands_aside_instead_and_calls_nobody() -> None:
    robot = connected(leader())
    robot.handle(empty_scan(0.1, FRONT), 0.1)
    commands = robot.handle(odometry(9.0, FRONT, moving=True), 9.0)
    assert only(LinkBroken, commands)
    assert not only(MusterCalled, commands)
    assert order_of(commands).target is None
    assert not only(MusterCalled, robot.handle(behind(9, echo_s=8.9), 9.0))


def test_who_has_slept_only_for_the_last_second_of_a_silence_calls_nobody_either() -> None:
    robot = connected(leader())
    unheard(robot, DEAD_S - SLEPT_S - 0.2)
    commands = robot.handle(odometry(DEAD_S, FRONT), DEAD_S)
    assert only(LinkBroken, commands)
    assert not only(MusterCalled, commands)


# --- following ------------------------------------------------------------------------------------


def at_the_front() -> Robot:
    """The follower, which has driven its first segment, to where the leader stood."""
    robot = follower()
    robot.handle(odometry(0.2, BACK), 0.2)
    robot.handle(ahead(3, authority_m=2.0, echo_s=0.8), 0.9)
    assert only(AskScan, robot.handle(odometry(1.0, FRONT, finished=1), 1.0))
    return robot


def test_the_scan_that_showed_a_followers_leg_clear_checks_its_first_segment() -> None:
    _, formed = takes_its_place()
    assert only(SegmentChecked, formed)[0].clear
    drive = order_of(formed)
    assert drive.target == Point(x_m=0.0, y_m=0.0), "to the next vertex first, where the leader stood"
    assert drive.reach_m == pytest.approx(0.5)


def test_a_follower_checks_the_segment_with_its_own_scan_before_it_enters_it() -> None:
    robot = at_the_front()
    commands = robot.handle(empty_scan(1.1, FRONT), 1.1)
    assert only(SegmentChecked, commands)[0].clear
    assert order_of(robot.handle(odometry(1.2, FRONT, finished=1), 1.2)).reach_m == pytest.approx(2.0)


def test_a_follower_drives_no_further_than_its_authority() -> None:
    robot = follower(authority_m=0.3)
    robot.handle(empty_scan(0.1, BACK), 0.1)
    assert order_of(robot.handle(odometry(0.2, BACK), 0.2)).reach_m == pytest.approx(0.3)


def test_an_authority_once_granted_is_not_taken_back_by_an_older_message() -> None:
    robot = follower(authority_m=0.3)
    robot.handle(empty_scan(0.1, BACK), 0.1)
    robot.handle(ahead(1, authority_m=0.1), 0.1)
    assert order_of(robot.handle(odometry(0.2, BACK), 0.2)).reach_m == pytest.approx(0.3)


def test_a_segment_that_is_not_clear_is_not_entered_and_looked_at_again() -> None:
    robot = at_the_front()
    before = order_of(robot.handle(odometry(1.0, FRONT, finished=1), 1.0)).number
    commands = robot.handle(scan_with_a_box_ahead(1.1, FRONT), 1.1)
    assert not only(SegmentChecked, commands)[0].clear
    robot.handle(ahead(4, authority_m=2.0, echo_s=1.8), 1.9)
    later = robot.handle(odometry(1.9, FRONT, finished=1), 1.9)
    assert order_of(later).number == before
    assert not only(AskScan, later)
    assert only(AskScan, robot.handle(odometry(2.2, FRONT, finished=1), 2.2))


def test_a_follower_arrives_when_the_robot_ahead_has_and_its_authority_is_used_up() -> None:
    robot = follower()
    robot.handle(empty_scan(0.1, BACK), 0.1)
    robot.handle(odometry(0.2, BACK), 0.2)
    robot.handle(odometry(0.3, FRONT, finished=1), 0.3)
    robot.handle(ahead(3, authority_m=2.0, arrived=True), 0.4)
    robot.handle(empty_scan(0.4, FRONT), 0.4)
    drive = order_of(robot.handle(odometry(0.5, FRONT, finished=1), 0.5))
    assert drive.reach_m == pytest.approx(2.0)
    there = Pose(x_m=1.5, y_m=0.0, heading_rad=0.0)
    arrived = robot.handle(odometry(0.9, there, finished=drive.number), 0.9)
    assert only(RobotArrived, arrived)[0].progress_m == pytest.approx(2.0)


def test_a_robot_that_slept_finds_out_before_it_believes_anything() -> None:
    robot = follower()
    robot.handle(empty_scan(0.1, BACK), 0.1)
    assert order_of(robot.handle(odometry(0.2, BACK), 0.2)).target is not None
    woken = robot.handle(odometry(9.0, BACK, moving=True), 9.0)
    assert only(LinkSilent, woken)
    assert order_of(woken).target is None
