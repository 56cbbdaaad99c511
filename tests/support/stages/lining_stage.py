"""One robot's part in a lining up, and what the others say in it. Not a test file."""

from collections.abc import Mapping

from agents.membership.lining import Lining
from msgspec.structs import replace
from protocol.epochs import called_epoch

from agents.body.driver import Driver
from agents.commands import Announce, Command
from agents.navigation.scan import View
from protocol.frames import Point, Pose
from protocol.mission import Law, Mission
from protocol.wire.messages import Muster, Odometry, Phase, Turn
from tests.support.stages.one_step import look_around, under
from world.geometry.shapes import Circle, Shape

RADIUS_M = 0.1
BOX: list[Shape] = [Circle(centre_m=(0.0, 2.0), radius_m=0.5)]
GOAL = Point(x_m=9.0, y_m=0.0)
PLACES = {robot: Pose(x_m=float(robot), y_m=0.0, heading_rad=0.0) for robot in (1, 2, 3)}


def mission(*, robots: int, goal: Point | None) -> Mission:
    """Of robots that look around well."""
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
    """A robot's, whose body stands there."""
    driver = Driver(speed_mps=0.3)
    driver.hear(Odometry(t_s=0.0, pose=pose, moving=False, finished=0, phase=Phase.RUNNING))
    return driver


def announced(commands: list[Command]) -> list[Muster]:
    """What a robot says of its lining up."""
    said = [command.muster for command in commands if isinstance(command, Announce)]
    return [each for each in said if isinstance(each, Muster)]


def says(lining: Lining, pose: Pose, scan: View | None, now_s: float) -> list[Muster]:
    """What it says when it stands there, and may have a scan."""
    return announced(lining.act(standing_at(pose), scan, now_s))


def at(robot: int, number: int = 1, *, t_s: float = 0.0) -> Muster:
    """What a robot says that has nothing to say but where it stands."""
    return Muster(number=number, pose=PLACES[robot], t_s=t_s)


def wants_scan(lining: Lining, pose: Pose) -> bool:
    """Whether it asks to look around from there."""
    return lining.wants_scan(standing_at(pose))


# --- an epoch that was called -----------------------------------------------------------------------

EPOCH = called_epoch(0, 1, 5.0)
TURN = Turn(number=1, robot=2)


def called(*, members: tuple[int, ...], shunned: frozenset[int] = frozenset()) -> Lining:
    """Robot 1's, in a muster that was called."""
    return Lining(1, mission(robots=3, goal=GOAL), 5.0, epoch=EPOCH, members=members, shunned=shunned)


def says_of_call(robot: int, number: int = 1, **news: object) -> Muster:
    """What a robot says in that muster, in which it knows all that are left out to stand."""
    return replace(at(robot, number), epoch=EPOCH, members=(1, 2, 3), **({"free_s": 0.0} | news))
