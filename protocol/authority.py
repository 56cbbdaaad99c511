"""Movement authority: how far along a path the robot behind may drive.

Rule 1: a robot may occupy the path ahead of it only up to its authority; no news means no motion.
Rule 2: authority only grows within an epoch, so an old message can only ask for less than is granted.
Rule 3: it ends where the path first comes nearer than `keep_m` to any ground that its granter may still
        occupy or is known to be going to: from the granter's progress to the end of the path it knows.
        Arc length alone does not do, since a hairpin brings two far arc lengths near.
Rule 4: the leader's next step keeps `keep_m` from all ground it has granted, which is what makes rule 3
        never ask for a grant back (`agents.certificate`).
"""

from itertools import pairwise

import numpy as np

from protocol.path import Path
from protocol.sweep import TOUCHING_M, nearest_on_segments, travel_m


def authority_m(path: Path, *, tail_m: float, progress_m: float, keep_m: float) -> float:
    """The arc length up to which the path is free of its granter [m].

    Args:
        path: the granter's path, planned ground included.
        tail_m: arc length of the strand's tail, behind which there is nobody.
        progress_m: the granter's own arc length.
        keep_m: least distance between the centres of two robots.
    """
    ground = path.between(progress_m, path.end_m)
    starts, ends = ground[:-1], ground[1:]
    keep = np.full(len(starts), keep_m)
    corners = path.between(min(tail_m, progress_m), progress_m)
    s_m = min(tail_m, progress_m)
    for corner, following in pairwise(corners):
        offset = nearest_on_segments(corner, starts, ends) - corner
        if np.hypot(offset[:, 0], offset[:, 1]).min() < keep_m - TOUCHING_M:
            return s_m
        length = float(np.hypot(*(following - corner)))
        if length == 0.0:
            continue
        free = float(travel_m(corner, ((following - corner) / length)[None, :], starts, ends, keep)[0])
        if free < length:
            return s_m + free
        s_m += length
    return s_m
