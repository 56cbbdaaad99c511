"""The clearance of a straight way from where a robot stands, from its own scan.

Rule 1: what is beside the way hides nothing on it: what it hides is further from the way. So hits are enough
        for a check of ground that a leader has certified.
Rule 2: a corner may reach nearer than the hits, between two rays. Beside a hit, and between rays that meet
        nothing within the range, it is no nearer than a scan is sure (`agents.navigation.sure`). Beside a
        hull that was taken out of the scan as a robot's, it begins where that robot keeps off obstacles and
        bodies. Where obstacles move, the hit may be of one, anywhere in what counts as hull: then it begins
        where the ray leaves the ground that all others keep off.
        What may be beyond the way's end, where no ray meets anything or behind a hull, is nearer to the robot
        ahead: that one keeps off it (`protocol.legs`).
Rule 3: a robot may leave what is too near to it, by a way that leads away. But a leg does not begin there:
        where the strand turns round, its tail comes back to where its leg began, and its drive errs again.
Rule 4: nor does a new leg end there. What the hull of the first robot hides beyond its place only that robot
        sees, before its first step (`agents.strand.leading`). It may have passed it by a little less than a
        step keeps (`agents.membership.joining`, rule 2); the rest of the tolerance is for the next drive.
"""

import math
from dataclasses import replace

import numpy as np

from agents.navigation.scan import View
from agents.navigation.sure import Sure, sure
from protocol.arrays import (
    Flags,
    Floats,
    distances_to_segments,
    nearest_on_segments,
    of_next,
    segments_apart,
)
from protocol.legs import PASSED_SHARE
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def seen_clearance_m(seen: View, end: Floats, mission: Mission) -> float:
    """The clearance of the hull, swept from the scan's position to `end` (2,), to the nearest hit [m]."""
    return _clearance_m(seen, end, _points(seen), mission, leaves=True)


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
    # A body is met by a ray wherever the way may be so long; a corner need not be.
    leave_out = ~seen.hits if bodies_only else _taken_out(seen, mission)
    known = sure(seen, mission, leave_out=leave_out, bodies_only=bodies_only)
    beside_hits = seen.hits | of_next(seen.hits)
    counts = np.isfinite(known.ranges_m) & (beside_hits | ~_is_beyond(known, seen, end))
    hidden = _behind_hulls(seen, end, mission, bodies_only=bodies_only)
    starts = np.concatenate([known.starts[counts], hidden[0]])
    ends = np.concatenate([known.ends[counts], hidden[1]])
    edges = np.stack([starts, ends])
    return _clearance_m(seen, end, edges, mission, leaves=bodies_only)


def _behind_hulls(seen: View, end: Floats, mission: Mission, *, bodies_only: bool) -> tuple[Floats, Floats]:
    """Rule 2: from where on hulls beside the way may hide something, as segments (n, 2), (n, 2)."""
    off_m = distances_to_segments(seen.points, seen.position, end)
    beside = _taken_out(seen, mission) & (off_m >= mission.hull_reach_m)
    past_m = np.minimum(seen.ranges_m + _free_behind_m(seen, beside, mission), mission.range_m_max)
    known = sure(replace(seen, ranges_m=past_m), mission, leave_out=~beside, bodies_only=bodies_only)
    hidden = np.isfinite(known.ranges_m) & ~_is_beyond(known, seen, end)
    return known.starts[hidden], known.ends[hidden]


def _free_behind_m(seen: View, beside: Flags, mission: Mission) -> Floats | float:
    """Rule 2: how far these rays are free behind hits that were taken out as a robot's (n,); others are 0."""
    radius_m = mission.robot_radius_m
    kept_m = radius_m + max(0.0, min(mission.epsilon_m, mission.separation_m) - mission.mu0_m)
    if not mission.obstacles_move:
        return math.sqrt(kept_m**2 - radius_m**2)
    hits, rays = seen.points[beside, None], seen.rays[beside, None]
    off = nearest_on_segments(hits, seen.robots[:, 0], seen.robots[:, 1]) - hits
    along_m = (off * rays).sum(axis=-1)
    inside_m2 = kept_m**2 - (off**2).sum(axis=-1)
    leaves_m = np.where(inside_m2 > 0.0, along_m + np.sqrt(along_m**2 + np.maximum(inside_m2, 0.0)), 0.0)
    free_m = np.zeros(len(beside))
    free_m[beside] = leaves_m.max(axis=1, initial=0.0)
    return free_m


def _taken_out(seen: View, mission: Mission) -> Flags:
    """The directions (n,) whose hits were taken out as a robot's."""
    return ~seen.hits & (seen.ranges_m < mission.range_m_max)


def _is_beyond(known: Sure, seen: View, end: Floats) -> Flags:
    """In which gaps (n,) the sure range ends beyond the way's end."""
    starts, ends = ((each - end) @ (end - seen.position) > 0.0 for each in (known.starts, known.ends))
    return np.asarray(starts & ends)


def certain_clearance_m_min(mission: Mission) -> float:
    """The clearance required on a way that no leader has certified; half the tolerance is for the drive."""
    return mission.clear_m - mission.mu0_m / 2.0


def leg_is_certain(seen: View, end: Floats, mission: Mission) -> bool:
    """Whether a way that no leader has certified is clear."""
    return certain_clearance_m(seen, end, mission) >= certain_clearance_m_min(mission)


def leg_meets_nothing(seen: View, end: Floats, mission: Mission) -> bool:
    """Whether such a way is clear of all hits."""
    seen_m = _clearance_m(seen, end, _points(seen), mission, leaves=False)
    return seen_m >= certain_clearance_m_min(mission)


def place_is_clear(seen: View, mission: Mission) -> bool:
    """Whether another robot may come to where the scan was taken (rule 4)."""
    least_m = mission.clear_m - PASSED_SHARE * mission.mu0_m
    return certain_clearance_m(seen, seen.position, mission) >= least_m


def _points(seen: View) -> Floats:
    """All hits, as edges (2, n, 2) without a length."""
    return np.stack([seen.hit_points, seen.hit_points])


def _clearance_m(seen: View, end: Floats, edges: Floats, mission: Mission, *, leaves: bool) -> float:
    """The clearance to edges (2, n, 2); rule 3 if the robot only leaves."""
    off_m = segments_apart(seen.position, end, *edges)
    if leaves:
        here_m = distances_to_segments(seen.position, *edges)
        near = here_m < mission.robot_radius_m + mission.clear_m
        off_m = off_m[~(near & (off_m >= here_m - TOUCHING_M))]
    return float(off_m.min(initial=mission.range_m_max)) - mission.robot_radius_m
