"""What the last robot in place does when nobody comes to a place behind it, though it has made way."""

import pytest
from agents.membership.announcer import Announcer
from agents.membership.giving import Giving
from msgspec.structs import replace
from protocol.epochs import called_epoch

from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.wire.messages import FIRST_ATTEMPT, Muster, Turn
from tests.support.stages.one_step import under

MEMBERS, EPOCH = (1, 2, 3), called_epoch(0, 1, 0.0)
GOAL = Point(x_m=9.0, y_m=0.0)
MISSION = replace(under(Law.CERTIFIED, robots=3, robot_radius_m=0.1), goal=GOAL)


def says(announcer: Announcer, robot: int, number: int, **news: object) -> None:
    """Another robot announces itself, from 1 m times its number behind the goal."""
    pose = Pose(x_m=GOAL.x_m - robot, y_m=0.0, heading_rad=0.0)
    muster = Muster(number=number, epoch=EPOCH, members=MEMBERS, pose=pose, leg_clear=robot < 3)
    announcer.roster.hear(robot, replace(muster, **news))


def stuck(*, arrived: bool) -> Giving:
    """Robot 2's, which stands behind robot 1, has made way for robot 3, in vain, and is in place again."""
    announcer = Announcer(2, MISSION, epoch=EPOCH, named=MEMBERS, members=MEMBERS, attempt=FIRST_ATTEMPT)
    giving = Giving(announcer, MISSION, arrived=arrived)
    announcer.say(pose=Pose(x_m=GOAL.x_m - 2.0, y_m=0.0, heading_rad=0.0), leg_clear=True)
    says(announcer, 1, 1)
    says(announcer, 3, 1)
    giving.give(0.0)
    assert announcer.said.gives == Turn(number=1, robot=3)
    says(announcer, 3, 2, ended=1)
    giving.give(1.0)
    assert announcer.said.gives == Turn(number=2, robot=1), "it makes way"
    says(announcer, 1, 2, gives=Turn(number=3, robot=3), ended=2, rank=0)
    says(announcer, 3, 3, ended=3)
    says(announcer, 1, 3, gives=Turn(number=4, robot=2), ended=2, rank=0)
    giving.begin()
    announcer.say(ended=4, rank=1, gives=None)
    giving.give(2.0)
    assert announcer.said.gives == Turn(number=5, robot=3)
    says(announcer, 3, 4, ended=5)
    giving.give(3.0)
    return giving


@pytest.mark.parametrize("arrived", [False, True])
def test_those_in_place_go_on_to_the_goal_without_the_others_and_only_then_try_another_order(
    *, arrived: bool
) -> None:
    giving = stuck(arrived=arrived)
    assert giving.goes_on_with == (() if arrived else (1, 2))
    assert giving.wants_another_order is arrived
