"""What rays that were cast from another place say about the gaps between the rays of a scan.

Premise: nothing has moved since but robots of the strand, whose distance grants keep.

Rule 1: a ray from another place was free up to its hit. If it crosses both rays of a gap before their hits,
        it divides the gap. A part of an obstacle there is connected, and enters behind both hits, so it lies
        behind that ray (`agents/navigation/sure.py`).
Rule 2: any ray that crosses proves that; which ones are tried is a matter of time alone. The best is the one
        that passes the two hits most closely, on the sensor's side.
"""

import numpy as np

from agents.navigation.scan import View
from protocol.arrays import Floats, of_next

TRIED = 4  # rays for each gap: the first may end before it has crossed, at the wall that the gap is of
PARALLEL = 1e-6  # sine of an angle at which a crossing is not computed
ROUNDING_M = 1e-9


def divided_m(view: View, true_m: Floats, other: View, error_m: float) -> Floats:
    """The range in each gap (n,) up to which a ray of another scan proves it empty; 0 where none does.

    Args:
        view: the scan.
        true_m: its ranges (n,), less the range error.
        other: a scan from another place.
        error_m: the largest error of its ranges.
    """
    off = other.position - view.position
    rays = view.rays
    ends = view.position + true_m[:, None] * rays - other.position
    to_view_rad = np.arctan2(-off[1], -off[0])
    turn_rad = _wrapped(to_view_rad - np.arctan2(ends[:, 1], ends[:, 0]))
    turns = np.stack([turn_rad, of_next(turn_rad)])
    side = np.sign(turns[0])
    is_beside = (side != 0.0) & (side == np.sign(turns[1]))
    count, spacing_rad = len(other.ranges_m), 2.0 * np.pi / len(other.ranges_m)
    # The first ray past both hits, on the way from them towards the sensor.
    first = (to_view_rad - side * np.abs(turns).min(axis=0) + np.pi) / spacing_rad
    first = np.where(side > 0.0, np.ceil(first), np.floor(first))
    best_m = np.zeros(len(rays))
    for index in range(TRIED):
        ray = (first + side * index).astype(np.intp) % count
        along = other.rays[ray]
        free_m = other.ranges_m[ray] - error_m
        crosses, nearest_m = is_beside, np.full(len(rays), np.inf)
        for direction, limit_m in ((rays, true_m), (of_next(rays), of_next(true_m))):
            sine = _cross(direction, along)
            safe = np.where(np.abs(sine) > PARALLEL, sine, 1.0)
            here_m, there_m = _cross(off, along) / safe, _cross(off, direction) / safe
            # The choice of rays alone would leave none that crosses behind a hit; rule 1 must not rest on it.
            crosses = crosses & (np.abs(sine) > PARALLEL) & (here_m > 0.0) & (here_m < limit_m)
            crosses = crosses & (there_m > 0.0) & (there_m < free_m)
            nearest_m = np.minimum(nearest_m, here_m)
        # Between the two crossings the ray may pass the sensor a little nearer than at either.
        nearest_m = nearest_m * np.cos(2.0 * np.pi / len(rays)) - ROUNDING_M
        best_m = np.maximum(best_m, np.where(crosses, nearest_m, 0.0))
    return best_m


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _wrapped(angles_rad: Floats) -> Floats:
    return np.asarray((angles_rad + np.pi) % (2.0 * np.pi) - np.pi)
