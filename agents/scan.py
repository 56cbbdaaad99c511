"""A scan as arrays: where it was taken, and the boundary of what it saw."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from protocol.messages import Scan
from protocol.sweep import Floats


@dataclass(frozen=True)
class View:
    """One scan, cut off at the range that the robot may rely on [m, rad; world frame]."""

    position: Floats
    """Where it was taken (2,)."""
    bearings_rad: Floats
    """Directions, anti-clockwise from -pi (n,)."""
    ranges_m: Floats
    """(n,)"""
    hits: NDArray[np.bool_]
    """Whether there was anything within the range (n,)."""

    @cached_property
    def points(self) -> Floats:
        """The boundary of what was seen (n, 2): hits, and places at the range limit."""
        directions = np.stack([np.cos(self.bearings_rad), np.sin(self.bearings_rad)], axis=1)
        return np.asarray(self.position + self.ranges_m[:, None] * directions)

    @property
    def hit_points(self) -> Floats:
        """The hits alone (k, 2)."""
        return np.asarray(self.points[self.hits])

    @property
    def nearest_m(self) -> float | None:
        """Distance to the nearest hit; None where there is none."""
        return float(self.ranges_m[self.hits].min()) if self.hits.any() else None

    def without(self, seen: NDArray[np.bool_]) -> "View":
        """The same scan with some of its directions taken for empty."""
        return View(self.position, self.bearings_rad, self.ranges_m, self.hits & ~seen)


def view(scan: Scan, *, range_m_max: float) -> View:
    """Make arrays of a scan; what is further away than the range counts as not seen."""
    ranges = np.minimum(np.array(scan.ranges_m), range_m_max)
    bearings = -np.pi + 2.0 * np.pi * np.arange(len(ranges)) / len(ranges)
    return View(np.array([scan.pose.x_m, scan.pose.y_m]), bearings, ranges, ranges < range_m_max)


def on_ground(points: Floats, corners: Floats, *, within_m: float) -> NDArray[np.bool_]:
    """Which points (n, 2) lie on a strip along a polyline (k, 2) of ground that robots stand on."""
    near = np.zeros(len(points), dtype=np.bool_)
    for start, end in pairwise(corners):
        near |= distances_to_segment(points, start, end) < within_m
    return near


def distances_to_segment(points: Floats, start: Floats, end: Floats) -> Floats:
    """Distance of each point (n, 2) to one segment (n,) [m]."""
    along = end - start
    length2 = float(along @ along)
    share = np.clip((points - start) @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
    return np.asarray(np.hypot(*(points - start - share[:, None] * along).T))


def on_discs(points: Floats, centres: Floats, *, within_m: float) -> NDArray[np.bool_]:
    """Which points (n, 2) lie on one of the discs around centres (k, 2)."""
    off = points[:, None, :] - centres[None, :, :]
    return np.asarray((np.hypot(off[..., 0], off[..., 1]) < within_m).any(axis=1))
