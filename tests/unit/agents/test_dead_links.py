"""A link that has been silent for too long: who leaves the strand, who calls, and who only stands aside."""

from agents.membership.calls import SLEPT_S

from agents.commands import Announce, Tell
from agents.events import TokenCame, TokenWent
from agents.robot import Robot
from protocol.keys import WORLD_NUMBER
from protocol.timeline import LinkBroken, MusterCalled
from protocol.wire.messages import Plea
from tests.support.stages.robot_stage import (
    FRONT,
    HEARD_S,
    MISSION,
    behind,
    empty_scan,
    leader,
    odometry,
    only,
    order_of,
)

DEAD_S = HEARD_S + MISSION.silence_s + MISSION.patience_s + 0.01


def unheard(robot: Robot, until_s: float) -> None:
    """The robot hears the one behind, which does not hear it; time goes on by heartbeats."""
    for beat in range(1, int(until_s / MISSION.heartbeat_s) + 1):
        now_s = beat * MISSION.heartbeat_s
        robot.handle(odometry(now_s, FRONT), now_s)
        robot.handle(behind(1 + beat, echo_s=HEARD_S), now_s)


def connected(robot: Robot) -> Robot:
    """It sees the tokens of the world and of robot 2."""
    for source in (WORLD_NUMBER, 2):
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
    robot.handle(TokenWent(WORLD_NUMBER, "a"), HEARD_S)
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
