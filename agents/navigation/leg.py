"""The clearance of a straight way from where a robot stands, from its own scan.

Obstacles beside the way hide nothing on it: what they hide is further from the way than they are. So the hits
alone are enough.
"""

import numpy as np

from agents.navigation.scan import View
from protocol.arrays import Floats, distances_to_segments
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def seen_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The clearance of the hull, swept from the scan's position to `end` (2,), to the nearest hit [m]."""
    return _clearance_m(seen, end, mission, np.zeros(int(seen.hits.sum())))


def certain_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The same clearance, minus the uncertainty of the scan [m]."""
    unsure_m = mission.range_error_m_max + mission.blind_per_range * seen.ranges_m[seen.hits]
    return _clearance_m(seen, end, mission, np.asarray(unsure_m))


def certain_clearance_m_min(mission: Mission) -> float:
    """The clearance required on a way that no leader has certified; half the tolerance is for the drive."""
    return mission.clear_m - mission.mu0_m / 2.0


def _clearance_m(seen: View, end: Floats, mission: Mission, unsure_m: Floats) -> float:
    off_m = distances_to_segments(seen.hit_points, seen.position, end)
    here_m = np.hypot(*(seen.hit_points - seen.position).T)
    # Hits that are too near already must not keep the robot there if the way leads away from them.
    near = here_m - unsure_m < mission.robot_radius_m + mission.clear_m
    left = near & (off_m >= here_m - TOUCHING_M)
    least_m = float((off_m - unsure_m)[~left].min(initial=mission.range_m_max))
    return least_m - mission.robot_radius_m
