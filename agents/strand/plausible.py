"""Whether a link state can be true, as far as this robot knows; one that cannot is refused and counted.

Rule 1: a robot tells the robot behind it only ahead states, and the robot ahead of it only behind states.
Rule 2: the path continues what is known, and each arc length is what the coordinates give.
Rule 3: no robot grants ground that it has not left, or ground beyond the path.
Rule 4: the robot behind is between its place in the formation and what it has been granted, its tail is not
        ahead of it, and it knows no more of the path than this robot.
"""

from protocol.keys import Keys, robot_name
from protocol.path import THERE_M, Path
from protocol.timeline import MessageRefused
from protocol.wire.messages import AheadState, BehindState

KEYS = Keys(fleet="", run="")  # a robot's core does not know the run's root
WRONG_SIDE = "its sender is on the other side of the link"  # rule 1


def refused(sender: int, receiver: int, reason: str) -> MessageRefused:
    """The record of a refused link state."""
    key = KEYS.link(robot_name(sender), robot_name(receiver))
    return MessageRefused(key=KEYS.behind_root(key), reason=reason)


def wrong_ahead(state: AheadState, path: Path) -> str | None:
    """Why a state of the robot ahead cannot be true (rules 2 and 3); None if it can."""
    told = state.path_from + len(state.path)
    if told > state.vertices:
        return f"tells {told} vertices of a path of {state.vertices}"
    if not path.fits(state.path_from, state.path):
        return "its path does not continue the known one"
    if state.authority_m > state.progress_m + THERE_M:
        return f"grants {state.authority_m:.3f} m, and stands at {state.progress_m:.3f} m"
    if told == state.vertices and state.path and state.authority_m > state.path[-1].s_m + THERE_M:
        return f"grants {state.authority_m:.3f} m of a path of {state.path[-1].s_m:.3f} m"
    return None


def wrong_behind(state: BehindState, *, vertices: int, start_m: float, granted_m: float) -> str | None:
    """Why a state of the robot behind cannot be true (rule 4); None if it can.

    Args:
        state: the state.
        vertices: how many of the path this robot knows.
        start_m: the place of the robot behind in the formation.
        granted_m: what it has been granted.
    """
    if not start_m - THERE_M <= state.progress_m <= granted_m + THERE_M:
        return f"stands at {state.progress_m:.3f} m, and may be at {start_m:.3f} to {granted_m:.3f} m"
    if state.tail_progress_m > state.progress_m + THERE_M:
        return "its tail is ahead of it"
    if state.vertices > vertices:
        return f"knows {state.vertices} vertices of a path of {vertices}"
    return None
