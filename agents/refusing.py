"""Well-formed messages that a robot refuses. Pure.

Rule 1: a message is refused if robots cannot have reached its epoch yet (`protocol.epochs`, rule 3).
"""

from agents.events import Event, LinkHeard, MusterHeard
from protocol.epochs import is_possible
from protocol.keys import Keys, robot_name
from protocol.timeline import MessageRefused

KEYS = Keys(fleet="", run="")  # a robot's core does not know the run's root, and names keys without it


def refusal(event: Event, receiver: int, now_s: float) -> MessageRefused | None:
    """The refusal of an event, with its reason; None if the robot accepts it."""
    match event:
        case MusterHeard(robot, said):
            epoch, key = said.epoch, KEYS.muster(robot_name(robot))
        case LinkHeard(robot=robot, state=state):
            epoch, key = state.epoch, KEYS.link(robot_name(robot), robot_name(receiver))
        case _:
            return None
    if is_possible(epoch, now_s):
        return None
    return MessageRefused(key=KEYS.behind_root(key), reason=f"epoch {epoch} is too far ahead of the time")
