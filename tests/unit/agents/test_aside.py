"""A robot that is in no strand, event by event: it stands, asks, and comes when it is called."""

import pytest
from agents.membership.calls import ASIDE_S, RANK_S
from msgspec.structs import replace
from protocol.epochs import called_epoch, of_one_call

from agents.commands import Announce, Command, Note, Order
from agents.events import MusterHeard, OdometryHeard, TokenCame
from agents.robot import LATE_S, Robot
from protocol.frames import Point, Pose
from protocol.keys import WORLD_NUMBER
from protocol.mission import Law
from protocol.timeline import MusterCalled, MusterJoined
from protocol.wire.messages import Announcement, Beacon, Muster, Odometry, Phase, Plea
from tests.support.stages.one_step import under

MISSION = under(Law.CERTIFIED, robots=3, robot_radius_m=0.1, goal=Point(x_m=9.0, y_m=0.0))
HERE, THERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=1.0, y_m=0.0, heading_rad=0.0)
WITHOUT = called_epoch(0, 1, 0.0)
WITH = called_epoch(WITHOUT, 1, 0.0)


def odometry(t_s: float) -> OdometryHeard:
    return OdometryHeard(Odometry(t_s=t_s, pose=HERE, moving=False, finished=0, phase=Phase.RUNNING))


def hears(robot: Robot, said: Announcement, now_s: float) -> list[Command]:
    return robot.handle(MusterHeard(1, said), now_s)


def called(epoch: int, *members: int) -> Muster:
    return Muster(number=1, epoch=epoch, pose=THERE, members=members)


def aside() -> Robot:
    """Robot 3, which has just heard that the others line up without it."""
    robot = Robot(3, MISSION)
    for source in (0, 1, 2):
        robot.handle(TokenCame(source, "a"), 0.0)
    robot.handle(odometry(0.0), 0.0)
    assert not joined(hears(robot, called(WITHOUT, 1, 2), 0.1))
    return robot


def joined(commands: list[Command]) -> list[int]:
    records = [command.record for command in commands if isinstance(command, Note)]
    return [record.epoch for record in records if isinstance(record, MusterJoined)]


def calls(commands: list[Command]) -> list[MusterCalled]:
    records = [command.record for command in commands if isinstance(command, Note)]
    return [record for record in records if isinstance(record, MusterCalled)]


def said(commands: list[Command]) -> list[Announcement]:
    return [command.muster for command in commands if isinstance(command, Announce)]


def test_it_stands_and_asks_from_time_to_time() -> None:
    robot = aside()
    commands = [
        command for beat in range(2, 12) for command in robot.handle(odometry(beat / 10.0), beat / 10.0)
    ]
    assert {type(each) for each in said(commands)} == {Plea}
    assert [command.drive.target for command in commands if isinstance(command, Order)] == [None] * 10


def test_it_answers_a_beacon_with_its_epoch_and_joins_the_muster_that_it_is_then_called_to() -> None:
    robot = aside()
    assert Plea(epoch=WITHOUT + 1, t_s=1.0) in said(hears(robot, Beacon(epoch=WITHOUT + 1, t_s=1.0), 1.0))
    commands = hears(robot, called(WITH, 1, 2, 3), 1.2)
    assert joined(commands) == [WITH]


def test_who_has_left_a_muster_does_not_come_back_to_it() -> None:
    robot = aside()
    hears(robot, called(WITH, 1, 2, 3), 0.2)
    later = called_epoch(WITH, 1, 0.3)
    assert not joined(hears(robot, called(later, 1, 2), 0.3))
    assert not joined(hears(robot, called(WITH, 1, 2, 3), 0.4))


def test_it_comes_though_it_has_heard_of_the_epoch_before_it_heard_the_call() -> None:
    robot = aside()
    robot.handle(MusterHeard(2, Plea(epoch=WITH, t_s=0.2)), 0.2)
    assert joined(hears(robot, called(WITH, 1, 2, 3), 0.3)) == [WITH]


def test_a_call_that_came_before_the_one_without_it_is_void() -> None:
    robot = Robot(3, MISSION)
    robot.handle(odometry(0.0), 0.0)
    assert not joined(hears(robot, called(WITH, 1, 2), 0.1))
    assert not joined(hears(robot, called(WITHOUT, 1, 2, 3), 0.2))


def test_as_long_as_the_others_line_up_without_it_it_does_not_call() -> None:
    robot, made = aside(), []
    for beat in range(2, 100):
        made += calls(hears(robot, called(WITHOUT, 1, 2), beat / 10.0))
        made += calls(robot.handle(odometry(beat / 10.0), beat / 10.0))
    assert made == []


def test_where_nobody_lines_up_and_nobody_leads_it_calls_all_itself() -> None:
    robot, at_s = aside(), 0.1
    made: list[MusterCalled] = []
    while not made:
        at_s += 0.1
        made += calls(robot.handle(MusterHeard(2, Plea(epoch=0, t_s=at_s)), at_s))
        made += calls(robot.handle(odometry(at_s), at_s))
    assert at_s == pytest.approx(0.1 + ASIDE_S + 3 * RANK_S, abs=0.11)
    (call,) = made
    assert call.members == (1, 2, 3)
    assert of_one_call(call.epoch, called_epoch(WITHOUT, 3, at_s))


def test_who_hears_nobody_does_not_call() -> None:
    robot = aside()
    made = [calls(robot.handle(odometry(beat / 10.0), beat / 10.0)) for beat in range(2, 150)]
    assert not any(made)


# --- who is started again -----------------------------------------------------------------------------

STARTED_S = 20.0


def started_again(odometry: OdometryHeard, *, again: bool = True) -> tuple[Robot, list[Command]]:
    """Robot 3, whose first odometry this is; what it does then."""
    robot = Robot(3, MISSION, again=again)
    return robot, robot.handle(odometry, odometry.odometry.t_s)


def test_who_is_started_again_begins_aside_and_answers_only_calls_made_since() -> None:
    robot, commands = started_again(odometry(STARTED_S))
    assert [type(each) for each in said(commands)] == [Plea]
    before, since = (called_epoch(0, 1, now_s) for now_s in (STARTED_S - 0.01, STARTED_S + 0.2))
    assert not joined(hears(robot, called(before, 1, 2, 3), STARTED_S + 0.1))
    assert joined(hears(robot, called(since, 1, 2, 3), STARTED_S + 0.3)) == [since]


@pytest.mark.parametrize(("at_s", "ordered"), [(LATE_S + 0.1, 0), (0.1, 1)])
def test_who_is_late_or_whose_body_has_had_orders_was_started_again_though_nobody_says_so(
    at_s: float, ordered: int
) -> None:
    heard = odometry(at_s)
    first = OdometryHeard(replace(heard.odometry, ordered=ordered))
    robot, commands = started_again(first, again=False)
    assert [type(each) for each in said(commands)] == [Plea]
    assert not joined(hears(robot, called(called_epoch(0, 1, 0.0), 1, 2, 3), at_s + 0.1))


def test_who_is_there_from_the_start_announces_itself_and_answers_any_call() -> None:
    robot, commands = started_again(odometry(LATE_S), again=False)
    assert [type(each) for each in said(commands)] == [Muster]
    assert joined(hears(robot, called(WITHOUT, 1, 2, 3), LATE_S + 0.1)) == [WITHOUT]


# --- who comes back while the others are stuck --------------------------------------------------------


def stuck() -> tuple[Robot, float]:
    """Robot 1, which leads robot 2, which has had its turn in vain; robot 3 has just come. And the time."""
    robot, epoch, members = Robot(1, MISSION), called_epoch(0, 2, 0.0), (1, 2)
    for source in (WORLD_NUMBER, 2):
        robot.handle(TokenCame(source, "a"), 0.0)
    robot.handle(odometry(0.0), 0.0)
    for beat in range(1, 40):
        now_s = beat / 10.0
        behind = Pose(x_m=-1.5, y_m=0.0, heading_rad=0.0)  # further than a link may be
        said = Muster(number=beat, epoch=epoch, pose=behind, members=members, leg_clear=False, hears=members)
        if now_s > 1.0:
            said = replace(said, turn=1, ended=1)
        robot.handle(MusterHeard(2, said), now_s)
        robot.handle(odometry(now_s), now_s)
    robot.handle(TokenCame(3, "a"), now_s)
    return robot, now_s


def test_who_asks_while_the_others_are_stuck_is_called_in_whatever_epoch_it_has_heard_of() -> None:
    robot, now_s = stuck()
    (call,) = calls(robot.handle(MusterHeard(3, Plea(epoch=0, t_s=now_s)), now_s))
    assert call.members == (1, 2, 3)


def test_who_lines_up_with_them_needs_no_call() -> None:
    robot, now_s = stuck()
    assert not calls(robot.handle(MusterHeard(2, Plea(epoch=0, t_s=now_s)), now_s))


def test_while_they_are_not_stuck_nobody_is_called_in() -> None:
    robot = Robot(1, MISSION)
    for source in (WORLD_NUMBER, 2):
        robot.handle(TokenCame(source, "a"), 0.0)
    robot.handle(odometry(0.0), 0.0)
    assert joined(robot.handle(MusterHeard(2, called(WITHOUT, 1, 2)), 0.1))
    robot.handle(odometry(0.1), 0.1)
    robot.handle(TokenCame(3, "a"), 0.15)
    assert not calls(robot.handle(MusterHeard(3, Plea(epoch=0, t_s=0.2)), 0.2))
