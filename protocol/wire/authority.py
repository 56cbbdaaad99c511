"""Movement authority: how far along a path the robot behind may drive.

Rule 1: a robot may occupy the path ahead of it only up to its authority; without messages it does not move.
Rule 2: authority only grows within an epoch, so an old message never grants more than a newer one.
Rule 3: it ends where the path first comes nearer than `keep_m` to ground that the granter may still occupy or
        will drive on: from the granter's progress to the end of the path it knows. Arc length alone is not
        enough, since in a hairpin two distant arc lengths are close in space. Here `keep_m` is
        `Mission.grant_keep_m`, which may be more than the `Mission.robot_keep_m` of rules 4 and 5.
Rule 4: under the certified law the leader's next step keeps `keep_m` from all granted ground. So rule 3 never
        takes a grant back (`agents.navigation.certificate`), and granted ground is not checked again. The
        paper's laws ignore the robots behind, and promise nothing.
Rule 5: a robot itself keeps `keep_m` from ground that robots behind it may drive on. Where the path is the
        leader's own (rule 4), this stops no robot. Where robots line up from scattered places, it can stop
        one: the way to the front may pass a robot that stands there and cannot go first.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

from protocol.path import Path
from protocol.sweep import TOUCHING_M, Place, distance_m, free_way_m

ROUNDING_M = 1e-6  # so little more is no way on, only the tolerance of what touches


def claim_m(
    path: Path, *, progress_m: float, to_m: float, tail_m: float, granted_m: float, keep_m: float
) -> float:
    """Rule 5: how far a robot itself may drive [m].

    Args:
        path: its path.
        progress_m: its own arc length.
        to_m: how far it wants to drive.
        tail_m: arc length of the strand's tail.
        granted_m: arc length up to which robots behind may drive.
        keep_m: least distance between the centres of two robots.
    """
    taken = path.corners(min(tail_m, granted_m), granted_m)
    s_m = progress_m
    for corner, following in pairwise(path.corners(progress_m, to_m)):
        free_m = free_way_m(corner, following, taken, keep_m)
        s_m += free_m
        if free_m < math.dist(corner, following):
            break
    return s_m


def authority_m(path: Path, *, from_m: float, progress_m: float, keep_m: float) -> float:
    """The arc length up to which the granter leaves the path free [m].

    Args:
        path: the granter's path, planned ground included.
        from_m: arc length up to which it is known to be free: the tail's, or the last grant.
        progress_m: the granter's own arc length.
        keep_m: least distance between the centres of two robots.
    """
    ground = path.corners(progress_m, path.end_m)
    s_m = min(from_m, progress_m)
    while (further_m := free_until_m(path, s_m, progress_m, ground, keep_m)) > s_m + ROUNDING_M:
        s_m = further_m  # from where a way only touches that ground, it may go on
    return s_m


def free_until_m(path: Path, from_m: float, to_m: float, ground: Sequence[Place], keep_m: float) -> float:
    """How far one look from `from_m` shows that the path keeps its distance from the ground [m]."""
    s_m = from_m
    for corner, following in pairwise(path.corners(from_m, to_m)):
        if distance_m(corner, ground) < keep_m - TOUCHING_M:
            break
        free_m = free_way_m(corner, following, ground, keep_m)
        s_m += free_m
        if free_m < math.dist(corner, following):
            break
    return s_m
