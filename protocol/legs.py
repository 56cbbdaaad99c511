"""How long the way to the robot ahead may be where a robot joins a strand. Pure."""

import math

import numpy as np

from protocol.arrays import Floats
from protocol.mission import DRIVE_SHARE, Mission
from protocol.path import THERE_M
from protocol.sweep import TOUCHING_M

LENGTHS = 8  # of legs tried
PLACE_SLACK_M = 0.01  # on what a place keeps, so that one that was aimed at is one when it is reached
PASSED_SHARE = 0.75  # of the tolerance: the rest is the drive's, on a way of a few decimetres


def off_place_m_max(mission: Mission) -> float:
    """How far beside its place on a path a robot may stand for a leg from or to there to count as driven.

    One drive may be so far off its way. Under a law that promises nothing there is no limit.
    """
    return DRIVE_SHARE * mission.mu0_m + THERE_M if mission.promises_clearance else math.inf


def leg_m_min(mission: Mission) -> float:
    """The shortest leg at which a robot aims."""
    return max(mission.robot_keep_m, mission.robot_radius_m + mission.obstacle_keep_m) + PLACE_SLACK_M


def legs_m(mission: Mission) -> Floats:
    """The lengths (n,) of legs that a robot tries; none: it can join nowhere. Its closest look counts."""
    rays = mission.closest_rays
    least_m, most_m = leg_m_min(mission), mission.leg_m_max - PLACE_SLACK_M
    lengths = np.linspace(least_m, most_m, LENGTHS if most_m >= least_m else 0)
    return lengths[[not hull_hides(length_m, rays, mission) for length_m in lengths.tolist()]]


def hull_hides(leg_m: float, rays: int, mission: Mission) -> bool:
    """Whether the robot ahead may hide an obstacle beside its place that is too near to the way there.

    Its hull hides everything behind it, out to the first ray that passes. From a short way off that may be
    beside the way, and not beyond its end, where an obstacle keeps off as it does from the robot ahead. That
    robot may have passed it by a little less than a step keeps (`agents.membership.joining`, rule 2). And
    the robot that drives on the leg may be off it by a drive's error. An obstacle that moves may stand beside
    the robot ahead, or over it, and hide as much as counts as its hull.

    The body of a robot that is left out may be nearer to the hull than that: the separation may be far below
    epsilon. But it is as wide as the hull, so it reaches out of the hull's shadow before the way ends, at no
    more than epsilon from the way, where it is seen. So there is no bound for the separation.
    """
    promised_m = mission.robot_radius_m + mission.epsilon_m - mission.mu0_m
    keeps_m = promised_m + (1.0 - PASSED_SHARE) * mission.mu0_m
    needs_m = promised_m + DRIVE_SHARE * mission.mu0_m * min(1.0, leg_m / mission.range_m_max)
    hull_m = mission.hull_reach_m if mission.obstacles_move else mission.robot_radius_m
    edge_rad = math.asin(min(1.0, hull_m / max(leg_m, TOUCHING_M))) + math.tau / rays
    beside_rad = edge_rad - math.acos(min(1.0, leg_m * math.sin(edge_rad) / keeps_m))
    return keeps_m * math.cos(max(0.0, beside_rad)) < needs_m
