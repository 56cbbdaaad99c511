"""Movement authority: how far along a path the robot behind may drive.

Rule 1: a robot may occupy the path ahead of it only up to its authority; no news means no motion.
Rule 2: authority only grows within an epoch, so an old message can only ask for less than is granted.
Rule 3: it ends where the path first comes nearer than `keep_m` to any ground that its granter may still
        occupy or is known to be going to: from the granter's progress to the end of the path it knows.
        Arc length alone does not do, since a hairpin brings two far arc lengths near.
Rule 4: under the certified law the leader's next step keeps `keep_m` from all ground it has granted, which
        is what makes rule 3 never ask for a grant back (`agents.navigation.certificate`); so what has been
        granted need not be looked at again. The paper's laws know nothing of robots behind, and promise
        nothing.
Rule 5: a robot itself drives no nearer than `keep_m` to ground that robots behind may drive on. Where the
        path is the leader's own (rule 4) this never stops anybody; where robots line up from scattered
        places, their way to the front may lead past one that stands and cannot go first.
"""

import math
from itertools import pairwise

from protocol.path import Path
from protocol.sweep import TOUCHING_M, distance_m, free_way_m


def claim_m(
    path: Path, *, progress_m: float, to_m: float, tail_m: float, granted_m: float, keep_m: float
) -> float:
    """Rule 5: how far a robot itself may drive [m].

    Args:
        path: its path.
        progress_m: its own arc length.
        to_m: how far it would drive.
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
    """The arc length up to which the path is free of its granter [m].

    Args:
        path: the granter's path, planned ground included.
        from_m: arc length up to which it is free as far as is known: the tail's, or what has been granted.
        progress_m: the granter's own arc length.
        keep_m: least distance between the centres of two robots.
    """
    ground = path.corners(progress_m, path.end_m)
    s_m = min(from_m, progress_m)
    for corner, following in pairwise(path.corners(s_m, progress_m)):
        if distance_m(corner, ground) < keep_m - TOUCHING_M:
            break
        free_m = free_way_m(corner, following, ground, keep_m)
        s_m += free_m
        if free_m < math.dist(corner, following):
            break
    return s_m
