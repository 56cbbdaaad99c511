"""One robot of a strand of two, event by event: its inputs and its commands. Not a test file."""

from collections.abc import Iterable
from typing import TypeVar

from agents.commands import Announce, AskScan, Command, Note, Order
from agents.events import LinkHeard, MusterHeard, OdometryHeard, ScanHeard
from agents.robot import Robot
from protocol.frames import Point, Pose, Vertex
from protocol.mission import Law, Mission
from protocol.timeline import StrandFormed
from protocol.wire.messages import AheadState, BehindState, Drive, Muster, Odometry, Phase, Scan
from tests.support.stages.one_step import under

MISSION = under(
    Law.CERTIFIED,
    robots=2,
    robot_radius_m=0.1,
    goal=Point(x_m=5.0, y_m=0.0),
    goal_tolerance_m=0.1,
)
FRONT, BACK = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=-0.5, y_m=0.0, heading_rad=0.0)
ORDER = (1, 2)
HEARD_S = 0.05  # when a robot receives its neighbour's first answer

T = TypeVar("T")


def odometry(t_s: float, at: Pose, *, finished: int = 0, moving: bool = False) -> OdometryHeard:
    return OdometryHeard(Odometry(t_s=t_s, pose=at, moving=moving, finished=finished, phase=Phase.RUNNING))


def muster(at: Pose, order: tuple[int, ...] = ORDER) -> Muster:
    """An announcement. The robot that knows the order also knows that its leg is clear."""
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
    """The leader, two metres further."""
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
    """Everything of a kind among commands or among the records that they note."""
    things = [command.record if isinstance(command, Note) else command for command in commands]
    return [thing for thing in things if isinstance(thing, kind)]


def musters(commands: Iterable[Command]) -> list[Muster]:
    return [each.muster for each in only(Announce, commands) if isinstance(each.muster, Muster)]


def order_of(commands: Iterable[Command]) -> Drive:
    return only(Order, commands)[-1].drive


def leader(mission: Mission = MISSION) -> Robot:
    """Robot 1, which leads and has just heard robot 2 behind it."""
    robot = Robot(1, mission)
    robot.handle(odometry(0.0, FRONT), 0.0)
    formed = robot.handle(MusterHeard(2, muster(BACK)), 0.0)
    assert only(StrandFormed, formed)[0].order == ORDER
    assert only(AskScan, robot.handle(behind(1, echo_s=HEARD_S), HEARD_S))
    return robot


def follower(authority_m: float = 2.0) -> Robot:
    """Robot 2, which follows and has just heard robot 1 ahead of it."""
    robot, formed = takes_its_place(authority_m)
    assert only(StrandFormed, formed)
    return robot


def takes_its_place(authority_m: float = 2.0) -> tuple[Robot, list[Command]]:
    """Robot 2, which has scanned its leg and then hears robot 1 ahead of it; also its commands."""
    robot = Robot(2, MISSION)
    robot.handle(odometry(0.0, BACK), 0.0)
    assert only(AskScan, robot.handle(MusterHeard(1, muster(FRONT)), 0.0))
    robot.handle(empty_scan(0.0, BACK), 0.0)
    formed = robot.handle(ahead(1, authority_m=authority_m), 0.0)
    return robot, formed + robot.handle(ahead(2, authority_m=authority_m, echo_s=HEARD_S), HEARD_S)
