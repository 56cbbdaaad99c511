"""The numpy array types of the project, and the geometry that robots and world share."""

from collections.abc import Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from protocol.frames import Point, Pose, Vertex

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]
Values = TypeVar("Values", Floats, Flags, Indices)


def xy(at: Point | Pose | Vertex) -> Floats:
    """A place as an array (2,)."""
    return np.array([at.x_m, at.y_m])


def places_xy(places: Sequence[Point | Pose | Vertex]) -> Floats:
    """Places as an array (n, 2)."""
    return np.array([(at.x_m, at.y_m) for at in places]).reshape(-1, 2)


def points_of(places: Floats) -> tuple[Point, ...]:
    """The same, back from an array."""
    return tuple(Point(x_m=x_m, y_m=y_m) for x_m, y_m in places.tolist())


def scan_bearings_rad(directions: int) -> Floats:
    """The directions of a scan: evenly spaced, anti-clockwise from -pi [world frame]."""
    return np.asarray(-np.pi + 2.0 * np.pi * np.arange(directions) / directions)


@lru_cache(maxsize=8)  # the sizes of scans in a run: a revolution, and closer looks
def scan_rays(directions: int) -> Floats:
    """The same as unit vectors (directions, 2), which nobody can make writable."""
    return np.frombuffer(unit_vectors(scan_bearings_rad(directions)).tobytes()).reshape(-1, 2)


def of_next(values: Values) -> Values:
    """The values (n, ...) of the next direction of a scan, or corner of a ring; `np.roll` is slow."""
    return np.concatenate((values[1:], values[:1]))


def of_previous(values: Values) -> Values:
    """The values (n, ...) of the previous direction of a scan, or corner of a ring."""
    return np.concatenate((values[-1:], values[:-1]))


def unit_vectors(bearings_rad: Floats) -> Floats:
    """The vectors (..., 2) of length 1 in these directions."""
    vectors = np.empty((*np.shape(bearings_rad), 2))
    vectors[..., 0], vectors[..., 1] = np.cos(bearings_rad), np.sin(bearings_rad)
    return vectors


def nearest_on_segments(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """The nearest point (..., 2) of each segment to each point, broadcast; a segment may have no length."""
    along = ends - starts
    square = (along * along).sum(axis=-1)
    share = ((points - starts) * along).sum(axis=-1) / np.where(square > 0.0, square, 1.0)
    return np.asarray(starts + np.clip(share, 0.0, 1.0)[..., None] * along)


def distances_to_segments(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """The distance (...,) from points to segments, broadcast; a segment may have no length."""
    return off_segments(points[..., 0], points[..., 1], starts, ends)


def off_segments(across: Floats, up: Floats, starts: Floats, ends: Floats) -> Floats:
    """The same for points whose coordinates x and y are given apart: those of a grid have an axis each."""
    x, y = across - starts[..., 0], up - starts[..., 1]
    dx, dy = ends[..., 0] - starts[..., 0], ends[..., 1] - starts[..., 1]
    square = dx * dx + dy * dy
    share = (x * dx + y * dy) / np.where(square > 0.0, square, 1.0)
    share = np.minimum(np.maximum(share, 0.0), 1.0)  # np.clip takes twice as long on few
    return np.asarray(np.hypot(x - share * dx, y - share * dy))


def segments_apart(starts: Floats, ends: Floats, corners: Floats, nexts: Floats) -> Floats:
    """The distance (...,) between pairs of segments, broadcast; 0 where they cross."""
    apart = np.minimum(
        np.minimum(
            distances_to_segments(starts, corners, nexts), distances_to_segments(ends, corners, nexts)
        ),
        np.minimum(distances_to_segments(corners, starts, ends), distances_to_segments(nexts, starts, ends)),
    )
    crosses = _on_both_sides(starts, ends, corners, nexts) & _on_both_sides(corners, nexts, starts, ends)
    return np.where(crosses, 0.0, apart)


def _on_both_sides(one: Floats, other: Floats, starts: Floats, ends: Floats) -> Flags:
    """Whether two points lie strictly on different sides of a line; a touch has distance 0 anyway."""
    dx, dy = ends[..., 0] - starts[..., 0], ends[..., 1] - starts[..., 1]
    left_of_one = dx * (one[..., 1] - starts[..., 1]) - dy * (one[..., 0] - starts[..., 0])
    left_of_other = dx * (other[..., 1] - starts[..., 1]) - dy * (other[..., 0] - starts[..., 0])
    return np.asarray(np.sign(left_of_one) * np.sign(left_of_other) < 0.0)
