"""One robot, event by event."""

import pytest
from msgspec.structs import replace

from agents.body.senses import RETRY_S
from agents.commands import Announce, AskScan, Order, Tell
from agents.events import LinkHeard, MusterHeard
from agents.robot import Robot
from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.timeline import (
    GoalReached,
    LinkSilent,
    MessageRefused,
    RobotArrived,
    RobotHeld,
    RouteLost,
    SegmentChecked,
    StepPlanned,
    StrandFormed,
)
from protocol.wire.messages import AheadState
from tests.support.stages.robot_stage import (
    BACK,
    FRONT,
    MISSION,
    ORDER,
    ahead,
    behind,
    empty_scan,
    follower,
    leader,
    muster,
    musters,
    odometry,
    only,
    order_of,
    scan_with_a_box_ahead,
    takes_its_place,
)

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


def test_an_announcement_is_repeated_again_and_again() -> None:
    robot = Robot(2, MISSION)
    robot.handle(odometry(0.0, BACK), 0.0)
    assert only(Announce, robot.handle(odometry(0.05, BACK), 0.05)) == []
    assert len(only(Announce, robot.handle(odometry(0.1, BACK), 0.1))) == 1


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


def test_a_follower_has_the_next_segment_checked_while_a_link_is_silent_and_drives_when_it_is_not() -> None:
    robot = at_the_front()
    silence = [robot.handle(odometry(t_s, FRONT, finished=1), t_s) for t_s in (1.0, 1.6, 2.2)]
    assert only(LinkSilent, silence[-1])
    assert only(AskScan, silence[-1])
    checked = robot.handle(empty_scan(2.2, FRONT), 2.2)
    assert only(SegmentChecked, checked)[0].clear
    waits = robot.handle(odometry(2.4, FRONT, finished=1), 2.4)
    assert order_of(waits).reach_m == pytest.approx(0.5), "it has no order but the one that is done"
    assert not only(AskScan, waits), "it has seen what it wanted to see"
    heard = robot.handle(ahead(4, authority_m=2.0, echo_s=2.4), 2.5)
    assert order_of(heard).reach_m == pytest.approx(2.0)


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


# --- what cannot be --------------------------------------------------------------------------------


def test_a_message_of_an_epoch_after_which_nobody_could_call_is_refused_and_changes_nothing() -> None:
    robot = Robot(2, MISSION)
    robot.handle(odometry(0.0, BACK), 0.0)
    last = replace(muster(FRONT), epoch=2**53, members=(1, 2))
    refused = only(MessageRefused, robot.handle(MusterHeard(1, last), 0.0))
    link = ahead(1, authority_m=0.0)
    far = LinkHeard(1, 1, replace(link.state, epoch=2**53))
    refused += only(MessageRefused, robot.handle(far, 0.0))
    assert [record.key for record in refused] == ["muster/r1", "link/r1/r2"]
    assert robot.epoch == 0


def test_before_it_knows_the_time_a_robot_neither_believes_such_a_message_nor_complains() -> None:
    robot = Robot(2, MISSION)
    assert robot.handle(MusterHeard(1, replace(muster(FRONT), epoch=2**53, members=(1, 2))), 0.0) == []
    assert only(MessageRefused, robot.handle(odometry(0.0, BACK), 0.0)) == []
    assert robot.epoch == 0
