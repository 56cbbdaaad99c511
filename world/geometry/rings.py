"""Properties of a closed ring of vertices: whether it is simple, its least width, its sharpest corner.

A ring is an `(n, 2)` array [m; world frame] in either orientation; the first vertex is not repeated.
"""

import math

import numpy as np

from protocol.arrays import Flags, Floats, Indices, of_next, of_previous


def _cross(a: Floats, b: Floats) -> Floats:
    product: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def anticlockwise(ring: Floats) -> Floats:
    """The same ring in anti-clockwise order."""
    seen = ring - ring[0]  # products of coordinates far from the origin leave no digit of a small area
    doubled_area = float(_cross(seen, of_next(seen)).sum())
    return ring if doubled_area > 0.0 else ring[::-1]


def _neighbours(count: int) -> Flags:
    """The pairs of edges that share a vertex; an edge is its own neighbour."""
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    near: Flags = (apart <= 1) | (apart == count - 1)
    return near


def is_simple(ring: Floats) -> bool:
    """Whether no two edges meet, except neighbours at their common vertex."""
    ends = of_next(ring)
    edges = ends - ring
    following = of_next(edges)
    folds_back = (_cross(edges, following) == 0.0) & ((edges * following).sum(axis=1) <= 0.0)
    if folds_back.any():  # also true for an edge without length
        return False
    # Signed sides of every vertex (column) seen from every edge (row).
    sides = _cross(edges[:, None], ring[None] - ring[:, None])
    straddles = sides * of_next(sides.T).T <= 0.0
    # Collinear edges straddle each other's lines; they meet only if their extents overlap too.
    low, high = np.minimum(ring, ends), np.maximum(ring, ends)
    overlap = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
    return not bool((straddles & straddles.T & overlap & ~_neighbours(len(ring))).any())


def corners_rad(ring: Floats) -> Floats:
    """The interior angle at each vertex of the ring in anti-clockwise order, in (0, 2 pi)."""
    ring = anticlockwise(ring)
    edges = of_next(ring) - ring
    before = of_previous(edges)
    interior: Floats = math.pi - np.arctan2(_cross(before, edges), (before * edges).sum(axis=1))
    return interior


def smallest_width_m(ring: Floats) -> float:
    """The shortest way through the inside, normal to an edge, that does not end at a neighbouring edge.

    A way to a neighbouring edge shrinks to 0 at every acute corner: corners count by their angle, not by a
    width. A triangle has only neighbouring edges; its width is its least height.
    """
    ring = anticlockwise(ring)
    count = len(ring)
    edges = of_next(ring) - ring
    lengths_m = np.hypot(edges[:, 0], edges[:, 1])
    along = edges / lengths_m[:, None]
    # Every vertex (column) in the frame of every edge (row): x along the edge, y inwards.
    x = ((ring[None] - ring[:, None]) * along[:, None]).sum(axis=2)
    y = _cross(along[:, None], ring[None] - ring[:, None])
    if count == 3:
        return float(y.max(axis=1).min())
    width_m = _least_height_over(x, y, lengths_m)
    width_m[_neighbours(count)] = math.inf
    return float(width_m.min())


def _least_height_over(x: Floats, y: Floats, lengths_m: Floats) -> Floats:
    """For each edge (row), the least height of each other edge (column) in the strip above it, or inf."""
    run, rise = of_next(x.T).T - x, of_next(y.T).T - y
    with np.errstate(divide="ignore", invalid="ignore"):
        # A vertical edge enters at -inf and leaves at inf, or never. Exactly on the side of the strip it is
        # nan and does not count; its ends belong to other edges too.
        at_sides = np.stack((-x / run, (lengths_m[:, None] - x) / run))
        enter, leave = at_sides.min(axis=0), at_sides.max(axis=0)
        heights = np.minimum(y + np.clip(enter, 0.0, 1.0) * rise, y + np.clip(leave, 0.0, 1.0) * rise)
    return np.where((enter <= 1.0) & (leave >= 0.0) & (heights > 0.0), heights, math.inf)


def winding(edges: Floats, points: Floats) -> tuple[Indices, Indices, Floats]:
    """The contributions of edges to winding numbers: index of point, index of edge, 1 or -1.

    Edges `(k, 4)` run anti-clockwise around their ring. The sum over a ring's edges is 1 inside and 0
    outside. For overlapping rings it is their number, so it is never 0 inside.
    """
    below = edges[:, 1] <= points[:, 1:]
    point, edge = np.nonzero(below != (edges[:, 3] <= points[:, 1:]))
    x1, y1, x2, y2 = edges[edge].T
    x, y = points[point].T
    left = (x2 - x1) * (y - y1) - (x - x1) * (y2 - y1)
    rises = below[point, edge]
    return point, edge, np.where(rises & (left > 0.0), 1.0, np.where(~rises & (left < 0.0), -1.0, 0.0))
