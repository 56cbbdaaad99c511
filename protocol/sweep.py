"""How far a disc may move straight on before it comes nearer than allowed to a line segment.

The disc is a point, and the segment a stadium: all points within the distance that must be kept.
A stadium is convex, so a point outside enters it at most once, and a point that is inside and moves
away from the segment never comes nearer again. Seen from outside it takes up no more than half of all
directions, most often far less: only headings within those are looked at.
"""

import numpy as np

from protocol.arrays import Floats, Indices, nearest_on_segments

TOUCHING_M = 1e-9  # nearer than this to a bound counts as on it: rounding of sums of metres
PARALLEL = 1e-12  # of a unit vector across a wall: over a kilometre it comes nearer by `TOUCHING_M`
GRAZING_RAD = 1e-7  # more than the rounding of an arc sine near 1, the square root of a double's last bit


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
    heading, segment = _in_sight(headings, starts, ends, keep_m)
    directions, keep_m = headings[heading].T, keep_m[segment]
    for entry in (
        _into_disc(directions, starts.T[:, segment], keep_m),
        _into_disc(directions, ends.T[:, segment], keep_m),
        _into_slab(directions, _sides(starts, ends)[:, segment], keep_m),
    ):
        np.minimum.at(free, heading, np.maximum(entry, 0.0))
    return free


def _in_sight(headings: Floats, starts: Floats, ends: Floats, keep_m: Floats) -> tuple[Indices, Indices]:
    """Which headings may lead into which stadium, as pairs (p,), (p,), seen from the origin."""
    start_rad, end_rad = np.arctan2(starts[:, 1], starts[:, 0]), np.arctan2(ends[:, 1], ends[:, 0])
    turn_rad = (end_rad - start_rad + np.pi) % (2.0 * np.pi) - np.pi
    half_start_rad, half_end_rad = _half_angle_rad(starts, keep_m), _half_angle_rad(ends, keep_m)
    low_rad = start_rad + np.minimum(-half_start_rad, turn_rad - half_end_rad) - GRAZING_RAD
    high_rad = start_rad + np.maximum(half_start_rad, turn_rad + half_end_rad) + GRAZING_RAD
    bearings_rad = np.arctan2(headings[:, 1], headings[:, 0])
    order = np.argsort(bearings_rad)
    twice_round_rad = np.concatenate([bearings_rad[order], bearings_rad[order] + 2.0 * np.pi])
    whole_turns_rad = np.floor((low_rad + np.pi) / (2.0 * np.pi)) * 2.0 * np.pi
    first = np.searchsorted(twice_round_rad, low_rad - whole_turns_rad)
    counts = np.searchsorted(twice_round_rad, high_rad - whole_turns_rad, side="right") - first
    segment = np.repeat(np.arange(len(starts)), counts)
    place = np.arange(len(segment)) + np.repeat(first - (np.cumsum(counts) - counts), counts)
    return order[place % len(order)], segment


def _half_angle_rad(centres: Floats, radii: Floats) -> Floats:
    """Half the angle that discs take up, seen from the origin; a right angle where that touches."""
    off_m = np.maximum(np.hypot(centres[:, 0], centres[:, 1]), radii)
    return np.asarray(np.arcsin(radii / np.where(off_m > 0.0, off_m, 1.0)))


def _into_disc(directions: Floats, centres: Floats, radii: Floats) -> Floats:
    """Distance to a disc in one direction each, (2, p), seen from the origin, which is in none of them."""
    along = directions[0] * centres[0] + directions[1] * centres[1]
    half_chord2 = radii**2 - (centres[0] ** 2 + centres[1] ** 2 - along**2)
    meets = (along > 0.0) & (half_chord2 > 0.0)
    return np.where(meets, along - np.sqrt(np.where(meets, half_chord2, 0.0)), np.inf)


def _sides(starts: Floats, ends: Floats) -> Floats:
    """Each segment's unit vector, its length, and where the origin is: along it and across (5, n)."""
    chord = (ends - starts).T
    length = np.hypot(*chord)
    unit = chord / np.where(length > 0.0, length, 1.0)
    along = -(starts[:, 0] * unit[0] + starts[:, 1] * unit[1])
    across = starts[:, 0] * unit[1] - starts[:, 1] * unit[0]
    return np.stack([*unit, length, along, across])


def _into_slab(directions: Floats, sides: Floats, keep_m: Floats) -> Floats:
    """Distance to the long side of a stadium in one direction each, (2, p), seen from the origin."""
    unit_x, unit_y, length, along, across = sides
    closing = (directions[0] * unit_y - directions[1] * unit_x) * np.sign(across)
    meets = closing > PARALLEL
    # A start nearer to the line than that, yet not inside, stands beyond the segment's ends or touches it.
    short = np.maximum(np.abs(across) - keep_m, 0.0)
    entry = np.where(meets, short, np.inf) / np.where(meets, closing, 1.0)
    foot = along + np.where(meets, entry, 0.0) * (directions[0] * unit_x + directions[1] * unit_y)
    return np.where(meets & (foot >= 0.0) & (foot <= length), entry, np.inf)
