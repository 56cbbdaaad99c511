"""How far a disc can move straight before it comes too near to a line segment.

The disc is reduced to a point, and the segment is grown to a stadium: all points within the distance to keep.
A stadium is convex, so a point outside enters it at most once. A point inside that moves away from the
segment never comes nearer again. Seen from outside, a stadium covers at most half of all directions, and
most often far fewer: only headings in those directions are checked.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from protocol.arrays import Floats, Indices, nearest_on_segments

TOUCHING_M = 1e-9  # nearer than this to a bound counts as on it: rounding of sums of metres
PARALLEL = 1e-12  # component of a unit vector across a wall: over 1 km the wall comes nearer by `TOUCHING_M`
FIRST_OF = 32  # segments per sample: neighbours are about equally far; 8 takes 50 % longer for 10,000
FEW = 1000  # pairs of heading and segment: a sample of fewer costs more than it saves
GRAZING_RAD = 1e-7  # above the rounding error of an arc sine near 1: the square root of a double's last bit

Place = tuple[float, float]  # x, y [m]


def free_way_m(origin: Place, target: Place, line: Sequence[Place], keep_m: float) -> float:
    """How far one straight way keeps its distance from a polyline [m]: `travel_m` for one heading.

    A robot calls this at every odometry with few segments, where plain numbers are much faster than arrays.
    """
    to_x, to_y = target[0] - origin[0], target[1] - origin[1]
    length_m = math.hypot(to_x, to_y)
    free_m = length_m
    if length_m == 0.0:
        return free_m
    x, y = to_x / length_m, to_y / length_m
    for start, end in _beside(origin, target, line, keep_m):
        off_x, off_y = _to_nearest(origin, start, end)
        off_m = math.hypot(off_x, off_y)
        if off_m < keep_m - TOUCHING_M:
            if x * off_x + y * off_y > TOUCHING_M:
                return 0.0
            continue
        kept_m = max(keep_m - (TOUCHING_M / 2.0 if off_m < keep_m + TOUCHING_M else 0.0), 0.0)
        seen = start[0] - origin[0], start[1] - origin[1], end[0] - origin[0], end[1] - origin[1]
        free_m = min(
            free_m,
            _to_disc(x, y, seen[0], seen[1], kept_m),
            _to_disc(x, y, seen[2], seen[3], kept_m),
            _to_slab(x, y, seen, kept_m),
        )
    return max(free_m, 0.0)


def distance_m(place: Place, line: Sequence[Place]) -> float:
    """The distance of a place from a polyline [m]."""
    return min(math.hypot(*_to_nearest(place, start, end)) for start, end in pairwise(line))


def _beside(
    origin: Place, target: Place, line: Sequence[Place], keep_m: float
) -> Iterator[tuple[Place, Place]]:
    """The segments whose bounding boxes may be too near to the way's bounding box."""
    reach_m = keep_m + TOUCHING_M
    low_x, high_x = min(origin[0], target[0]) - reach_m, max(origin[0], target[0]) + reach_m
    low_y, high_y = min(origin[1], target[1]) - reach_m, max(origin[1], target[1]) + reach_m
    for start, end in pairwise(line):
        beyond_x = max(start[0], end[0]) < low_x or min(start[0], end[0]) > high_x
        if not beyond_x and max(start[1], end[1]) >= low_y and min(start[1], end[1]) <= high_y:
            yield start, end


def _to_nearest(place: Place, start: Place, end: Place) -> Place:
    """The vector from a place to the nearest point of a segment."""
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    square = along_x * along_x + along_y * along_y
    share = (place[0] - start[0]) * along_x + (place[1] - start[1]) * along_y
    share = min(max(share / square, 0.0), 1.0) if square > 0.0 else 0.0
    return start[0] + share * along_x - place[0], start[1] + share * along_y - place[1]


def _to_disc(x: float, y: float, centre_x: float, centre_y: float, radius: float) -> float:
    """`_into_disc` of one heading and one disc."""
    along = x * centre_x + y * centre_y
    half_chord2 = radius * radius - (centre_x * centre_x + centre_y * centre_y - along * along)
    return along - math.sqrt(half_chord2) if along > 0.0 and half_chord2 > 0.0 else math.inf


def _to_slab(x: float, y: float, seen: tuple[float, float, float, float], keep_m: float) -> float:
    """`_into_slab` of one heading and one segment, seen from the origin."""
    chord_x, chord_y = seen[2] - seen[0], seen[3] - seen[1]
    length_m = math.hypot(chord_x, chord_y)
    if length_m == 0.0:
        return math.inf
    unit_x, unit_y = chord_x / length_m, chord_y / length_m
    along, across = -(seen[0] * unit_x + seen[1] * unit_y), seen[0] * unit_y - seen[1] * unit_x
    closing = (x * unit_y - y * unit_x) * math.copysign(1.0, across)
    if across == 0.0 or closing <= PARALLEL:
        return math.inf
    entry_m = max(abs(across) - keep_m, 0.0) / closing
    foot = along + entry_m * (x * unit_x + y * unit_y)
    return entry_m if 0.0 <= foot <= length_m else math.inf


def travel_m(origin: Floats, headings: Floats, starts: Floats, ends: Floats, keep_m: Floats) -> Floats:
    """The free distance from `origin` in each direction; see `Stadiums`."""
    return Stadiums(origin, starts, ends, keep_m).travel_m(headings)


class Stadiums:
    """Segments, each with the distance to keep from it, as they lie around one place."""

    def __init__(
        self, origin: Floats, starts: Floats, ends: Floats, keep_m: Floats, *, away: float = 0.0
    ) -> None:
        """Look around.

        Args:
            origin: where motions start (2,) [m].
            starts: one end of each segment (n, 2) [m].
            ends: the other end (n, 2) [m].
            keep_m: distance to keep from each segment (n,) [m].
            away: sine of the angle by which a motion has to lead away from one that is nearer than that.
        """
        to_nearest = nearest_on_segments(origin, starts, ends) - origin
        off_m = np.hypot(to_nearest[:, 0], to_nearest[:, 1])
        inside = off_m < keep_m - TOUCHING_M
        self._to_inside = to_nearest[inside]
        self._approach_m = TOUCHING_M - away * off_m[inside]
        # Where the start touches, rounding must not decide whether a motion along the wall is free.
        keep_m = np.maximum(keep_m - np.where(off_m < keep_m + TOUCHING_M, TOUCHING_M / 2.0, 0.0), 0.0)
        # Only `_to_inside` speaks for a segment that is nearer than its distance.
        self._nearest_m = np.where(inside, np.inf, off_m - keep_m - TOUCHING_M)
        x, y = np.stack([starts - origin, ends - origin], axis=1).T  # (2, n) each: of both ends
        self._shapes = _shapes(x, y, keep_m)
        self._low_rad, self._high_rad = _seen_rad(x, y, keep_m)

    def travel_m(self, headings: Floats) -> Floats:
        """The free distance in each direction.

        Args:
            headings: unit vectors (h, 2).

        Returns:
            Metres for each heading (h,), infinite where nothing is in the way. A segment that is already
            nearer than its distance forbids only motion that does not lead away from it.
        """
        free = np.full(len(headings), np.inf)
        if len(self._to_inside):
            approaching = headings @ self._to_inside.T > self._approach_m
            free[approaching.any(axis=1)] = 0.0
        order, first, counts = self._in_sight(headings)

        def shorten(some: Indices) -> None:
            """Shorten the headings to what these segments leave free."""
            segment, place = np.repeat(some, counts[some]), _counted_up(first[some], counts[some])
            heading = order[place % len(order)]
            matters = self._nearest_m[segment] < free[heading]
            if matters.any():
                to, of = heading[matters], segment[matters]
                np.minimum.at(free, to, self._entries(headings[to].T, of))

        rows = np.arange(len(counts))
        if counts.sum() > FEW:  # a first sample shows how few of the others matter
            shorten(rows[::FIRST_OF])
            rows = rows[self._nearest_m < _largest(free[order], first, counts)]
        shorten(rows)
        return free

    def _entries(self, directions: Floats, segment: Indices) -> Floats:
        """Distance to one stadium in one direction each, (2, p), from the origin, which is outside all."""
        shapes = self._shapes[:, segment]
        entry = np.minimum(_into_discs(directions, shapes[:7]), _into_slab(directions, shapes[7:]))
        return np.maximum(entry, 0.0)

    def _in_sight(self, headings: Floats) -> tuple[Indices, Indices, Indices]:
        """The order of the headings (h,); and in it the first that may meet each stadium, and how many."""
        bearings_rad = np.arctan2(headings[:, 1], headings[:, 0])
        order = np.argsort(bearings_rad)
        twice_round_rad = np.concatenate([bearings_rad[order], bearings_rad[order] + 2.0 * np.pi])
        first = np.searchsorted(twice_round_rad, self._low_rad)
        return order, first, np.searchsorted(twice_round_rad, self._high_rad, side="right") - first


def _largest(values: Floats, first: Indices, counts: Indices) -> Floats:
    """The largest (n,) of `counts` values from `first` on, cyclically; where the count is 0, any value."""
    spans = np.stack([first, first + counts], axis=1).ravel()
    return np.asarray(np.maximum.reduceat(np.concatenate([values, values, [0.0]]), spans)[::2])


def _counted_up(first: Indices, counts: Indices) -> Indices:
    """The numbers of all spans, one after the other: of each, `counts` numbers from `first` on."""
    return np.asarray(np.arange(counts.sum()) + np.repeat(first - (np.cumsum(counts) - counts), counts))


def cut_where_near(
    origin: Floats, starts: Floats, ends: Floats, keep_m: Floats
) -> tuple[Floats, Floats, Floats]:
    """The same segments and distances; a segment that comes too near to the origin is cut where it does.

    A stadium lets a motion pass that begins inside it and comes no nearer. Beside a long segment each drive
    error would bring the next motion nearer; the parts that are not too near stop such motions.
    """
    chord = ends - starts
    length2 = (chord**2).sum(axis=1)
    per_m2 = 1.0 / np.where(length2 > 0.0, length2, np.inf)
    middle = ((origin - starts) * chord).sum(axis=1) * per_m2
    off2 = ((starts + middle[:, None] * chord - origin) ** 2).sum(axis=1)
    half = np.sqrt(np.maximum(keep_m**2 - off2, 0.0) * per_m2)
    low, high = np.clip(middle - half, 0.0, 1.0), np.clip(middle + half, 0.0, 1.0)
    near = low < high
    shares = np.stack([np.zeros(near.sum()), low[near], high[near], np.ones(near.sum())])
    part, of = np.nonzero(np.diff(shares, axis=0) > 0.0)
    cuts = starts[near][of] + shares[np.stack([part, part + 1]), of][..., None] * chord[near][of]
    return (
        np.concatenate([starts[~near], cuts[0]]),
        np.concatenate([ends[~near], cuts[1]]),
        np.concatenate([keep_m[~near], keep_m[near][of]]),
    )


def _seen_rad(x: Floats, y: Floats, keep_m: Floats) -> tuple[Floats, Floats]:
    """The directions (n,), (n,) between which each stadium is seen, the first in (-pi, pi]."""
    start_rad, end_rad = np.arctan2(y, x)
    turn_rad = (end_rad - start_rad + np.pi) % (2.0 * np.pi) - np.pi
    off_m = np.maximum(np.hypot(x, y), keep_m)
    # Half the angle that the discs cover; a right angle where the origin touches.
    half_start_rad, half_end_rad = np.arcsin(keep_m / np.where(off_m > 0.0, off_m, 1.0))
    low_rad = start_rad + np.minimum(-half_start_rad, turn_rad - half_end_rad) - GRAZING_RAD
    high_rad = start_rad + np.maximum(half_start_rad, turn_rad + half_end_rad) + GRAZING_RAD
    whole_turns_rad = np.floor((low_rad + np.pi) / (2.0 * np.pi)) * 2.0 * np.pi
    return low_rad - whole_turns_rad, high_rad - whole_turns_rad


def _shapes(x: Floats, y: Floats, keep_m: Floats) -> Floats:
    """What `_into_discs` needs of each stadium (7, n), and what `_into_slab` needs (7, n)."""
    chord_x, chord_y = x[1] - x[0], y[1] - y[0]
    length_m = np.hypot(chord_x, chord_y)
    safe_m = np.where(length_m > 0.0, length_m, 1.0)
    unit_x, unit_y = chord_x / safe_m, chord_y / safe_m
    along_m = -(x[0] * unit_x + y[0] * unit_y)
    across_m = x[0] * unit_y - y[0] * unit_x
    side = np.sign(across_m)
    # An origin that is nearer to the line but not inside is beyond the segment's ends, or touches it.
    short_m = np.maximum(np.abs(across_m) - keep_m, 0.0)
    discs = [*x, *y, *(x**2 + y**2), keep_m**2]
    return np.stack([*discs, unit_x, unit_y, side * unit_y, side * unit_x, length_m, along_m, short_m])


def _into_discs(directions: Floats, discs: Floats) -> Floats:
    """Distance to the nearer end's disc in one direction each, (2, p), from the origin, which is outside."""
    x, y, off2, radius2 = discs[0:2], discs[2:4], discs[4:6], discs[6]
    along = directions[0] * x + directions[1] * y
    half_chord2 = radius2 - (off2 - along**2)
    meets = (along > 0.0) & (half_chord2 > 0.0)
    entry = np.where(meets, along - np.sqrt(np.maximum(half_chord2, 0.0)), np.inf)
    return np.asarray(entry.min(axis=0))


def _into_slab(directions: Floats, slabs: Floats) -> Floats:
    """Distance to the long side of a stadium in one direction each, (2, p), from the origin."""
    unit_x, unit_y, side_y, side_x, length, along, short = slabs
    closing = directions[0] * side_y - directions[1] * side_x
    meets = closing > PARALLEL
    entry = short / np.where(meets, closing, 1.0)
    foot = along + entry * (directions[0] * unit_x + directions[1] * unit_y)
    return np.where(meets & (foot >= 0.0) & (foot <= length), entry, np.inf)
