"""The clearance of a straight way from where a robot stands, from its own scan.

Obstacles beside the way hide nothing on it: what they hide is further from the way than they are. So the hits
alone are enough.
"""

import math

import numpy as np

from agents.navigation.scan import View
from agents.navigation.sure import sure
from protocol.arrays import Floats, distances_to_segments, segments_apart
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def seen_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The clearance of the hull, swept from the scan's position to `end` (2,), to the nearest hit [m]."""
    return _clearance_m(seen, end, mission, seen.hit_points, seen.hit_points)


def certain_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The same clearance to where an obstacle may be that was hit [m]."""
    return _certain_m(seen, end, mission, bodies_only=False)


def body_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The same clearance to where the body of a robot may be that was hit [m].

    0 on a way so long that near its end a whole body fits between two rays.
    """
    radius_m = mission.robot_radius_m
    # A ray is sure to hit a body whose centre is nearer than this.
    sees_all_m = radius_m / math.sin(math.pi / len(seen.ranges_m))
    if float(np.hypot(*(end - seen.position))) + 2.0 * radius_m + mission.clear_m > sees_all_m:
        return 0.0
    return _certain_m(seen, end, mission, bodies_only=True)


def _certain_m(seen: View, end: Floats, mission: Mission, *, bodies_only: bool) -> float:
    known = sure(seen, mission, leave_out=~seen.hits, bodies_only=bodies_only)
    beside_hits = np.isfinite(known.ranges_m)
    return _clearance_m(seen, end, mission, known.starts[beside_hits], known.ends[beside_hits])


def certain_clearance_m_min(mission: Mission) -> float:
    """The clearance required on a way that no leader has certified; half the tolerance is for the drive."""
    return mission.clear_m - mission.mu0_m / 2.0


def leg_is_certain(seen: View, end: Floats, mission: Mission) -> bool:
    """Whether a way that no leader has certified is clear."""
    return certain_clearance_m(seen, end, mission) >= certain_clearance_m_min(mission)


def is_unsure_of_leg(seen: View, end: Floats, mission: Mission) -> bool:
    """Whether such a way is clear of all hits, but not of what the scan may have missed."""
    is_seen_clear = seen_clearance_m(seen, end, mission) >= certain_clearance_m_min(mission)
    return is_seen_clear and not leg_is_certain(seen, end, mission)


def _clearance_m(seen: View, end: Floats, mission: Mission, starts: Floats, ends: Floats) -> float:
    off_m = segments_apart(seen.position, end, starts, ends)
    here_m = distances_to_segments(seen.position, starts, ends)
    # What is too near already must not keep the robot there if the way leads away from it.
    near = here_m < mission.robot_radius_m + mission.clear_m
    left = near & (off_m >= here_m - TOUCHING_M)
    return float(off_m[~left].min(initial=mission.range_m_max)) - mission.robot_radius_m
