"""What a robot's scan shows of the leg to the robot ahead, while all robots stand. Pure."""

import numpy as np

from agents.navigation.leg import certain_clearance_m_min, is_unsure_of_leg, leg_is_certain
from agents.navigation.scan import View, on_discs
from agents.navigation.sure import closer
from protocol.arrays import Floats, distances_to_segments
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def without_hulls(view: View, robots: Floats, mission: Mission) -> View:
    """A scan without what it shows of robots that stand (n, 2)."""
    return view.without(on_discs(view.points, robots, within_m=mission.hull_reach_m))


def leg_is_clear(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Whether the straight way to the robot ahead (2,) is, in a scan without hulls."""
    return _leg_may_be_clear(seen, ahead, mission) and leg_is_certain(seen, ahead, mission)


def leg_needs_closer_look(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Whether only what the scan may have missed blocks that way, and a closer look may show it."""
    return (
        closer(mission, len(seen.ranges_m)) is not None
        and _leg_may_be_clear(seen, ahead, mission)
        and is_unsure_of_leg(seen, ahead, mission)
    )


def _leg_may_be_clear(seen: View, ahead: Floats, mission: Mission) -> bool:
    if not np.hypot(*(ahead - seen.position)) <= mission.leg_m_max:
        return False
    return not hides_way(seen, ahead, mission)


def hides_way(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Whether a hull that was taken out of a scan stands on the way: the scan shows nothing behind it.

    The robot ahead apart, at whose place the way ends. What stands beside the way hides nothing of it.
    """
    taken_out = seen.points[~seen.hits & (seen.ranges_m < mission.range_m_max)]
    hulls = taken_out[~on_discs(taken_out, ahead[None], within_m=mission.hull_reach_m)]
    leg_m = float(np.hypot(*(ahead - seen.position)))
    along_m = (hulls - seen.position) @ (ahead - seen.position) / max(leg_m, TOUCHING_M)
    on_way_m = distances_to_segments(hulls, seen.position, ahead)
    needs_m = mission.robot_radius_m + certain_clearance_m_min(mission)
    onward = (along_m > 0.0) & (along_m < leg_m - needs_m)  # around its place the robot ahead keeps clear
    return bool((onward & (on_way_m < needs_m)).any())
