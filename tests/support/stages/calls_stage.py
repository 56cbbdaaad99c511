"""The knowledge of one robot of five, from which it decides on calls. Not a test file."""

from agents.membership.calls import Calls

from protocol.keys import WORLD_NUMBER
from protocol.mission import Law
from tests.support.stages.one_step import under

MISSION = under(Law.CERTIFIED, robots=5, robot_radius_m=0.1)


def calls(*shown: int, robot: int = 1, now_s: float = 0.0) -> Calls:
    """A robot's, which is connected and sees the tokens of some others."""
    made = Calls(robot, MISSION)
    for source in (WORLD_NUMBER, *shown):
        made.presence.come(source, "a", now_s)
    return made
