"""The certificate: the clearance that holds along a whole step, promised before the step is driven.

Rule 1: the free polygon of a scan joins consecutive hits and range-limit points. Every edge counts as a
        wall: surface, occlusion or range limit, since nothing is known beyond it.
Rule 2: a step is certified if the disc of radius r + epsilon, swept along it, stays inside. Each edge is
        widened by the uncertainty of the scan there: the range error, and how far an obstacle may reach past
        its last ray, which grows with range.
Rule 3: a step keeps the robots' distance from ground that robots behind may still reach. From the bounds of
        the region it keeps the hull's radius and the tolerance.
Rule 4: an edge that is already nearer than its distance only forbids motion towards it.
"""

from dataclasses import dataclass

import numpy as np

from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, Indices, distances_to_segments, nearest_on_segments
from protocol.mission import Bounds, Mission
from protocol.sweep import travel_m

PIECE = 1.25  # so an edge is at most a quarter wider than necessary
NEAR_M = 0.01  # nearer than this, the uncertainty of a scan is negligible beside the clearance


@dataclass(frozen=True)
class Walls:
    """Segments, each with the distance that a robot's centre must keep from it [m; world frame]."""

    starts: Floats
    ends: Floats
    keep_m: Floats

    def eased(self, origin: Floats, least_m: Floats) -> "Walls":
        """The same for a robot that already stands nearer to some edges: it may pass these at `least_m`."""
        off = nearest_on_segments(origin, self.starts, self.ends) - origin
        # With as much margin: some edges of one hull are nearer than that, and the next edge just not.
        near = np.hypot(off[:, 0], off[:, 1]) < 2.0 * self.keep_m - least_m
        return Walls(self.starts, self.ends, np.where(near, np.minimum(self.keep_m, least_m), self.keep_m))

    @staticmethod
    def joined(*parts: "Walls") -> "Walls":
        """All segments of several walls."""
        return Walls(
            np.concatenate([part.starts for part in parts]),
            np.concatenate([part.ends for part in parts]),
            np.concatenate([part.keep_m for part in parts]),
        )


def scan_walls(view: View, mission: Mission, *, leave_out: Flags | None = None) -> Walls:
    """Rules 1 and 2: the free polygon's edges, those across a jump in range in pieces.

    If a direction is left out, the edges on both sides of it are left out, but not their other ends.
    """
    edge, starts, ends, far = _pieces(view)
    blind_per_range = mission.blind_per_range_in(len(view.ranges_m))
    unsure = mission.range_error_m_max + blind_per_range * far
    walls = Walls(starts, ends, mission.obstacle_keep_m + unsure)
    if leave_out is None:
        return walls
    kept = ~(leave_out | np.roll(leave_out, -1))[edge]
    lone = ~leave_out & (np.roll(leave_out, 1) | np.roll(leave_out, -1))
    lone_keep_m = mission.obstacle_keep_m + mission.range_error_m_max + blind_per_range * view.ranges_m[lone]
    return Walls.joined(
        Walls(walls.starts[kept], walls.ends[kept], walls.keep_m[kept]),
        Walls(view.points[lone], view.points[lone], lone_keep_m),
    )


def _pieces(view: View) -> tuple[Indices, Floats, Floats, Floats]:
    """The edges, split into pieces along which the range grows at most by `PIECE`.

    An edge behind an obstacle reaches far away. Near the obstacle it must not be as wide as at its far end.

    Returns:
        For each piece: the index of its edge, its two ends, and its far range.
    """
    ranges = np.maximum(view.ranges_m, NEAR_M)
    near, far = np.sort(np.stack([ranges, np.roll(ranges, -1)]), axis=0)
    counts = np.maximum(np.ceil(np.log(far / near) / np.log(PIECE)), 1.0).astype(int)
    edge = np.repeat(np.arange(len(counts)), counts)
    piece = np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)
    count, near, far = counts[edge], near[edge], far[edge]

    def at(index: Floats) -> tuple[Floats, Floats]:
        """Range at the index-th joint from the near end of each edge, and its share of the edge's length."""
        range_m = near * (far / near) ** (index / count)
        spread = far - near
        return range_m, np.where(spread > 0.0, (range_m - near) / np.where(spread > 0.0, spread, 1.0), index)

    (_, share_0), (range_m, share_1) = at(piece.astype(np.float64)), at(piece + 1.0)
    here, there = view.points[edge], np.roll(view.points, -1, axis=0)[edge]
    near_first = (ranges <= np.roll(ranges, -1))[edge][:, None]
    from_point, to_point = np.where(near_first, here, there), np.where(near_first, there, here)
    along = to_point - from_point
    return edge, from_point + share_0[:, None] * along, from_point + share_1[:, None] * along, range_m


def ground_walls(corners: Floats, keep_m: float) -> Walls:
    """A polyline (n, 2) of ground that robots behind may still reach, as walls (rule 3)."""
    return Walls(corners[:-1], corners[1:], np.full(len(corners) - 1, keep_m))


def bounds_walls(bounds: Bounds, mission: Mission) -> Walls:
    """The four sides of the region, as walls (rule 3)."""
    low, high = (bounds.x_m_min, bounds.y_m_min), (bounds.x_m_max, bounds.y_m_max)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    return Walls(corners, np.roll(corners, -1, axis=0), np.full(4, mission.robot_radius_m + mission.mu0_m))


def certified_lengths_m(origin: Floats, headings_rad: Floats, walls: Walls) -> Floats:
    """The longest certified step in each heading (h,) [m], for all headings against all edges at once."""
    headings = np.stack([np.cos(headings_rad), np.sin(headings_rad)], axis=1)
    return travel_m(origin, headings, walls.starts, walls.ends, walls.keep_m)


def promised_clearance_m(view: View, target: Floats, robots: Flags, mission: Mission) -> float:
    """The least clearance of the hull along a step from any obstacle consistent with the scan [m].

    It is less than epsilon only if the step begins nearer than that to something and leads away from it.

    Args:
        view: the scan that the step was planned from.
        target: where the step ends (2,) [m; world frame].
        robots: the directions of the scan that hit the robot directly behind. It is no obstacle: grants keep
            the distance to it. Robots further behind count as obstacles; they are further away.
        mission: the robot's mission.
    """
    walls = scan_walls(view, mission, leave_out=robots)
    margin = walls.keep_m - mission.obstacle_keep_m
    off_ends = distances_to_segments(walls.starts, view.position, target)
    off_edges = [distances_to_segments(end, walls.starts, walls.ends) for end in (view.position, target)]
    apart = np.minimum(off_ends, np.minimum(*off_edges))
    return max(0.0, float((apart - margin).min()) - mission.robot_radius_m)
