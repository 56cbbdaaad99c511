"""A scan as arrays: its position and the boundary of what it saw."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from protocol.arrays import Flags, Floats, distances_to_segments, scan_bearings_rad, scan_rays
from protocol.wire.messages import Scan

NOWHERE: Floats = np.empty((0, 2, 2))


@dataclass(frozen=True)
class View:
    """One scan, cut off at the range that the robot may rely on [m, rad; world frame].

    Its arrays are fixed: a law sees them before the certificate does.
    """

    position: Floats
    """The position of the scan (2,)."""
    bearings_rad: Floats
    """Directions, anti-clockwise from -pi (n,)."""
    ranges_m: Floats
    """Ranges (n,)."""
    hits: Flags
    """Whether there was a hit within the range (n,)."""
    t_s: float
    """The time of the scan."""
    earlier: tuple["View", ...] = ()
    """Scans from other places that still hold: nothing has moved since but robots of the strand."""
    robots: Floats = field(default_factory=lambda: NOWHERE)
    """Where the robots may be whose hits were removed: segments (m, 2, 2) of ground, each from and to."""

    def __post_init__(self) -> None:
        fix(self.position, self.bearings_rad, self.ranges_m, self.hits, self.robots)

    @property
    def rays(self) -> Floats:
        """The directions as unit vectors (n, 2)."""
        return scan_rays(len(self.bearings_rad))

    @cached_property
    def points(self) -> Floats:
        """The boundary of what was seen (n, 2): hits, and points at the range limit."""
        points = np.asarray(self.position + self.ranges_m[:, None] * self.rays)
        fix(points)
        return points

    @property
    def hit_points(self) -> Floats:
        """The points of the hits (k, 2)."""
        return np.asarray(self.points[self.hits])

    @property
    def nearest_m(self) -> float | None:
        """Distance to the nearest hit, or None."""
        return float(self.ranges_m[self.hits].min()) if self.hits.any() else None

    def copied(self) -> "View":
        """The same in arrays of its own, without earlier scans and the ground of robots."""
        return replace(
            self,
            position=self.position.copy(),
            bearings_rad=self.bearings_rad.copy(),
            ranges_m=self.ranges_m.copy(),
            hits=self.hits.copy(),
            earlier=(),
            robots=NOWHERE,
        )

    def without(self, seen: Flags, robots: Floats) -> "View":
        """The same scan with the hits of these directions removed, which are of robots on these segments."""
        return replace(self, hits=self.hits & ~seen, robots=robots)

    def without_on(self, grounds: Iterable[Floats], *, within_m: float) -> "View":
        """The same scan without the hits near polylines (k, 2) of ground where robots may be."""
        seen, robots = np.zeros(len(self.hits), dtype=np.bool_), [NOWHERE]
        for corners in grounds:
            seen |= on_ground(self.points, corners, within_m=within_m)
            robots.append(np.stack([corners[:-1], corners[1:]], axis=1))
        return self.without(seen, np.concatenate(robots))


def fix(*arrays: Floats | Flags) -> None:
    """Make arrays unchangeable from now on."""
    for each in arrays:
        each.setflags(write=False)


def view(scan: Scan, *, range_m_max: float) -> View:
    """The scan as arrays; anything beyond the range counts as not seen."""
    ranges = np.minimum(np.array(scan.ranges_m), range_m_max)
    bearings = scan_bearings_rad(len(ranges))
    position = np.array([scan.pose.x_m, scan.pose.y_m])
    return View(position, bearings, ranges, ranges < range_m_max, scan.t_s)


def on_ground(points: Floats, corners: Floats, *, within_m: float) -> Flags:
    """The points (n, 2) within a strip along a polyline (k, 2) of ground where robots stand."""
    near = np.zeros(len(points), dtype=np.bool_)
    for start, end in pairwise(corners):
        near |= distances_to_segments(points, start, end) < within_m
    return near


def on_discs(points: Floats, centres: Floats, *, within_m: float) -> Flags:
    """The points (n, 2) within one of the discs around centres (k, 2)."""
    off = points[:, None, :] - centres[None, :, :]
    return np.asarray((np.hypot(off[..., 0], off[..., 1]) < within_m).any(axis=1))
