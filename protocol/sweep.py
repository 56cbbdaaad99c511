"""How far a disc may move straight on before it comes nearer than allowed to a line segment.

The disc is a point, and the segment a stadium: all points within the distance that must be kept.
A stadium is convex, so a point outside enters it at most once, and a point that is inside and moves
away from the segment never comes nearer again.
"""

import numpy as np

from protocol.arrays import Floats, nearest_on_segments

TOUCHING_M = 1e-9  # nearer than this to a bound counts as on it: rounding of sums of metres
PARALLEL = 1e-12  # of a unit vector across a wall: over a kilometre it comes nearer by `TOUCHING_M`


def travel_m(origin: Floats, headings: Floats, starts: Floats, ends: Floats, keep_m: Floats) -> Floats:
    """How far one may go from `origin` in each direction.

    Args:
        origin: where the motion starts (2,) [m].
        headings: unit vectors (h, 2).
        starts: one end of each segment (n, 2) [m].
        ends: the other end (n, 2) [m].
        keep_m: distance to keep from each segment (n,) [m].

    Returns:
        Metres for each heading (h,), infinite where nothing is in the way. A segment that is already
        nearer than its distance forbids motion towards it and no other.
    """
    if len(starts) == 0:
        return np.full(len(headings), np.inf)
    to_nearest = nearest_on_segments(origin, starts, ends) - origin
    off_m = np.hypot(to_nearest[:, 0], to_nearest[:, 1])
    inside = off_m < keep_m - TOUCHING_M
    free = np.full(len(headings), np.inf)
    if inside.any():
        approaching = headings @ to_nearest[inside].T > TOUCHING_M
        free[approaching.any(axis=1)] = 0.0
    # Where the start touches, the last bits must not decide whether one may go along.
    keep_m = np.maximum(keep_m - np.where(off_m < keep_m + TOUCHING_M, TOUCHING_M / 2.0, 0.0), 0.0)
    starts, ends, keep_m = starts[~inside] - origin, ends[~inside] - origin, keep_m[~inside]
    for entry in (_into_discs(headings, starts, keep_m), _into_discs(headings, ends, keep_m)):
        free = np.minimum(free, entry)
    return np.asarray(np.minimum(free, _into_slabs(headings, starts, ends, keep_m)))


def _into_discs(headings: Floats, centres: Floats, radii: Floats) -> Floats:
    """Distance to the first disc in each heading, seen from the origin, which is in none of them."""
    along = headings @ centres.T
    beside2 = np.einsum("ij,ij->i", centres, centres) - along**2
    half_chord2 = radii**2 - beside2
    meets = (along > 0.0) & (half_chord2 > 0.0)
    entry = np.where(meets, along - np.sqrt(np.where(meets, half_chord2, 0.0)), np.inf)
    return np.asarray(np.maximum(entry.min(axis=1, initial=np.inf), 0.0))


def _into_slabs(headings: Floats, starts: Floats, ends: Floats, keep_m: Floats) -> Floats:
    """Distance to the first long side of a stadium in each heading, seen from the origin."""
    chord = ends - starts
    length = np.hypot(chord[:, 0], chord[:, 1])
    unit = chord / np.where(length > 0.0, length, 1.0)[:, None]
    normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    across = -np.einsum("ij,ij->i", starts, normal)  # the origin's offset from the segment's line
    along = -np.einsum("ij,ij->i", starts, unit)
    closing = -(headings @ normal.T) * np.sign(across)
    meets = closing > PARALLEL
    # A start nearer to the line than that, yet not inside, stands beyond the segment's ends or touches it.
    short = np.maximum(np.abs(across) - keep_m, 0.0)
    entry = np.where(meets, short, np.inf) / np.where(meets, closing, 1.0)
    foot = along + np.where(meets, entry, 0.0) * (headings @ unit.T)
    entry = np.where(meets & (foot >= 0.0) & (foot <= length), entry, np.inf)
    return np.asarray(np.maximum(entry.min(axis=1, initial=np.inf), 0.0))
