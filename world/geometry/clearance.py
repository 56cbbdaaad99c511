"""Least distances along straight moves: to obstacles, and between bodies [m; world frame].

Rule 1: distances are from the centre of a body; the caller subtracts the hull's radius.
Rule 2: an obstacle is solid: inside it the distance is 0.
"""

import math

import numpy as np

from protocol.arrays import Floats, Indices, distances_to_segments, segments_apart
from world.geometry import ellipses
from world.geometry.rings import winding
from world.geometry.shapes import Ground

ROUNDING_M = 1e-9  # an upper bound of the error of distances up to 1 km


def clearance(ground: Ground, starts: Floats, ends: Floats) -> Floats:
    """The least distance of each straight move, `(n, 2)` to `(n, 2)`, to any obstacle; inf without any."""
    moves_m = np.hypot(*(ends - starts).T)
    least_m = _to_circles(ground.circles, starts, ends, moves_m)
    least_m = np.minimum(least_m, _to_edges(ground, starts, ends, moves_m))
    return np.minimum(least_m, _to_ellipses(ground, starts, ends, moves_m, others_m=least_m))


def clearance_at(ground: Ground, points: Floats) -> Floats:
    """The distance of each point, `(n, 2)`, to any obstacle; inf without any. Faster than `clearance`."""
    discs = ground.discs
    if len(discs) == 0:
        return np.full(len(points), math.inf)
    to_centres_m = _to_points(points, discs[:, :2])
    off_m = to_centres_m - discs[:, 2]
    # An obstacle whose disc is further than what lies within another cannot be the nearest.
    body, disc = np.nonzero(off_m <= (to_centres_m - ground.inner_radii_m).min(axis=1)[:, None] + ROUNDING_M)
    apart_m = off_m[body, disc]
    first_ellipse, first_edge = len(ground.circles), len(ground.circles) + len(ground.ellipses)
    at_edge, at_circle = disc >= first_edge, disc < first_ellipse
    if at_edge.any():
        edges = ground.edges[disc[at_edge] - first_edge]
        apart_m[at_edge] = distances_to_segments(points[body[at_edge]], edges[:, :2], edges[:, 2:])
    if not (at_edge | at_circle).all():
        of_ellipse = ~(at_edge | at_circle)
        rows = ground.ellipses[disc[of_ellipse] - first_ellipse]
        apart_m[of_ellipse] = ellipses.point_distances(rows, points[body[of_ellipse]])
    least_m = _least(len(points), body, np.maximum(apart_m, 0.0))
    return least_m if len(ground.edges) == 0 else np.where(_turns(ground, points) != 0.0, 0.0, least_m)


def keep_off(ground: Ground, starts: Floats, ends: Floats, apart_m: float) -> bool:
    """Whether straight moves that start outside all obstacles keep more than this distance from all."""
    discs = ground.discs
    off_m = distances_to_segments(discs[:, :2], starts[:, None], ends[:, None]) - discs[:, 2]
    body, disc = np.nonzero(off_m <= apart_m)
    # Few moves are near few obstacles: most often one edge or one ellipse is left.
    first_ellipse, first_edge = len(ground.circles), len(ground.circles) + len(ground.ellipses)
    if (disc < first_ellipse).any():
        return False  # a circle is its disc
    at_edge = disc >= first_edge
    by, edges = body[at_edge], ground.edges[disc[at_edge] - first_edge]
    if len(by) and segments_apart(starts[by], ends[by], edges[:, :2], edges[:, 2:]).min() <= apart_m:
        return False
    by, rows = body[~at_edge], ground.ellipses[disc[~at_edge] - first_ellipse]
    return not len(by) or bool(ellipses.move_distances(rows, starts[by], ends[by]).min() > apart_m)


def distances(ground: Ground, point_in_world: Floats) -> Floats:
    """The distance from one point to each obstacle, in the scenario's order."""
    apart_m = np.full(ground.shape_count, math.inf)
    to_centres_m = np.hypot(*(ground.circles[:, :2] - point_in_world).T)
    apart_m[ground.circle_owner] = np.maximum(to_centres_m - ground.circles[:, 2], 0.0)
    apart_m[ground.ellipse_owner] = ellipses.point_distances(ground.ellipses, point_in_world)
    to_edges_m = distances_to_segments(point_in_world, ground.edges[:, :2], ground.edges[:, 2:])
    np.minimum.at(apart_m, ground.edge_owner, to_edges_m)
    turns = np.zeros(ground.shape_count)
    _, edge, turn = winding(ground.edges, point_in_world[None])
    np.add.at(turns, ground.edge_owner[edge], turn)
    return np.where(turns != 0.0, 0.0, apart_m)


def separations(starts: Floats, ends: Floats) -> Floats:
    """The least distance of each pair of bodies in simultaneous straight moves, `(n, n)`; inf to itself."""
    x, y = (np.subtract.outer(column, column) for column in starts.T)
    dx, dy = (np.subtract.outer(column, column) for column in (ends - starts).T)
    squares = dx * dx + dy * dy
    share = np.clip(-(x * dx + y * dy) / np.where(squares > 0.0, squares, 1.0), 0.0, 1.0)
    x, y = x + share * dx, y + share * dy
    apart_m: Floats = np.sqrt(x * x + y * y)
    np.fill_diagonal(apart_m, math.inf)
    return apart_m


def _to_circles(circles: Floats, starts: Floats, ends: Floats, moves_m: Floats) -> Floats:
    if len(circles) == 0:
        return np.full(len(starts), math.inf)
    to_rims_m = _to_points(starts, circles[:, :2]) - circles[:, 2]
    body, row = _may_be_nearest(to_rims_m, to_rims_m, moves_m)
    if len(body) == 0:
        return np.full(len(starts), math.inf)
    to_centres_m = distances_to_segments(circles[row, :2], starts[body], ends[body])
    return _least(len(starts), body, np.maximum(to_centres_m - circles[row, 2], 0.0))


def _to_ellipses(
    ground: Ground, starts: Floats, ends: Floats, moves_m: Floats, *, others_m: Floats
) -> Floats:
    """The least distance to any ellipse; inf if the other obstacles are nearer than all of them."""
    rows = ground.ellipses
    if len(rows) == 0:
        return np.full(len(starts), math.inf)
    to_centres_m = _to_points(starts, rows[:, :2])
    most_m, least_m = ground.ellipse_reach_m
    # All or none: Newton's steps end when all rows converge, so the last bits depend on the set of rows.
    if (to_centres_m - most_m > (others_m + moves_m + ROUNDING_M)[:, None]).all():
        return np.full(len(starts), math.inf)
    body, row = _may_be_nearest(to_centres_m - most_m, to_centres_m - least_m, moves_m)
    if len(body) == 0:
        return np.full(len(starts), math.inf)  # Newton's steps would take as long for no rows as for a few
    return _least(len(starts), body, ellipses.move_distances(rows[row], starts[body], ends[body]))


def _to_edges(ground: Ground, starts: Floats, ends: Floats, moves_m: Floats) -> Floats:
    edges = ground.edges
    if len(edges) == 0:
        return np.full(len(starts), math.inf)
    middles, half_lengths_m = ground.edge_middles
    to_middles_m = _to_points(starts, middles)
    body, edge = _may_be_nearest(to_middles_m - half_lengths_m, to_middles_m, moves_m)
    least_m = np.full(len(starts), math.inf)
    if len(body) > 0:
        apart_m = segments_apart(starts[body], ends[body], edges[edge, :2], edges[edge, 2:])
        np.minimum.at(least_m, body, apart_m)
    return np.where(_turns(ground, starts) != 0.0, 0.0, least_m)


def _turns(ground: Ground, points: Floats) -> Floats:
    """How often rings go around each point; not 0 within a polygon."""
    point, _, turn = winding(ground.edges, points)
    return np.asarray(np.bincount(point, weights=turn, minlength=len(points)), dtype=np.float64)


def _to_points(starts: Floats, points: Floats) -> Floats:
    """The distance from every start to every point, `(n, k)`; three times as fast as `hypot`."""
    x, y = starts[:, :1] - points[:, 0], starts[:, 1:] - points[:, 1]
    apart: Floats = np.sqrt(x * x + y * y)
    return apart


def _may_be_nearest(nearest_m: Floats, farthest_m: Floats, moves_m: Floats) -> tuple[Indices, Indices]:
    """Pairs of body and obstacle for the exact and slower functions.

    An obstacle that is further than another by more than the length of the move cannot become the nearest.
    """
    bound_m = farthest_m.min(axis=1) + moves_m
    body, obstacle = np.nonzero(nearest_m <= bound_m[:, None])
    return body, obstacle


def _least(count: int, body: Indices, apart_m: Floats) -> Floats:
    least_m = np.full(count, math.inf)
    np.minimum.at(least_m, body, apart_m)
    return least_m
