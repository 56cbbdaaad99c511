"""The straight way from where a robot stands, as its own scan shows it.

Obstacles beside the way hide nothing that is on it: what they hide is further off the way than they are.
So the hits alone say how clear it is.
"""

import numpy as np

from agents.navigation.scan import View
from protocol.arrays import Floats, distances_to_segments
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def seen_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """Of the hull, swept from where the scan was taken to `end` (2,), to the nearest hit [m]."""
    return _clearance_m(seen, end, mission, np.zeros(int(seen.hits.sum())))


def certain_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The same, less what the scan may be wrong by [m]."""
    unsure_m = mission.range_error_m_max + mission.blind_per_range * seen.ranges_m[seen.hits]
    return _clearance_m(seen, end, mission, np.asarray(unsure_m))


def certain_clearance_m_min(mission: Mission) -> float:
    """What a way has to have that nobody else has certified: half of the tolerance is left for the drive."""
    return mission.clear_m - mission.mu0_m / 2.0


def _clearance_m(seen: View, end: Floats, mission: Mission, unsure_m: Floats) -> float:
    off_m = distances_to_segments(seen.hit_points, seen.position, end)
    here_m = np.hypot(*(seen.hit_points - seen.position).T)
    # What is too near already, and the way leads away from, must not keep the robot there.
    near = here_m - unsure_m < mission.robot_radius_m + mission.clear_m
    left = near & (off_m >= here_m - TOUCHING_M)
    least_m = float((off_m - unsure_m)[~left].min(initial=mission.range_m_max))
    return least_m - mission.robot_radius_m
