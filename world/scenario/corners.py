"""The sharpest corner that a ray can meet: what robots are told of the obstacles' shapes, and nothing else.

Rule 1: a corner that lies inside another obstacle is not met. What reaches nearest to a sensor there is the
        other obstacle. A moving obstacle covers none, since it may leave the corner bare.
Rule 2: a polygon of more than four corners counts as no blunter than 60 degrees (`Polygon.bluntest_rad`):
        several corners may fit between two rays, each blunt, and their tip be sharper.
Rule 3: the limit of a premise may only be too sharp: ellipses cover nothing, nor do two obstacles together.
"""

import math
from collections.abc import Sequence

import numpy as np

from protocol.arrays import Floats, distances_to_segments
from world.geometry.clearance import distances
from world.geometry.rings import anticlockwise, corners_rad
from world.geometry.shapes import Ground, Polygon, Shape, ground_of

COVERED_M = 1e-3  # inside by so much: rounding of coordinates must not decide whether a ray meets a corner


def sharpest_corner_rad(still: Sequence[Shape], moving: Sequence[Shape] = ()) -> float:
    """The least angle of any corner that a ray can meet, at most a right angle."""
    polygons = [shape for shape in still if isinstance(shape, Polygon)]
    bare = [*moving, *(shape for shape in still if not isinstance(shape, Polygon))]
    together_rad = [polygon.bluntest_rad for polygon in polygons]
    least_rad = min([math.pi / 2, *together_rad, *(shape.sharpest_corner_rad for shape in bare)])
    if not polygons:
        return least_rad
    angles_rad = np.concatenate([corners_rad(polygon.ring_m) for polygon in polygons])
    corners = np.concatenate([anticlockwise(polygon.ring_m) for polygon in polygons])
    sharp = np.flatnonzero(angles_rad < least_rad)
    ground = ground_of(still)
    for corner in sharp[np.argsort(angles_rad[sharp], kind="stable")]:
        if not _is_covered(ground, corners[corner]):
            return float(angles_rad[corner])
    return least_rad


def _is_covered(ground: Ground, corner: Floats) -> bool:
    """Rule 1; the corner's own shape has it on its outline."""
    around = np.flatnonzero(distances(ground, corner) == 0.0)
    circles = ground.circles[np.isin(ground.circle_owner, around)]
    if (circles[:, 2] - np.hypot(*(circles[:, :2] - corner).T) >= COVERED_M).any():
        return True
    for owner in np.intersect1d(around, ground.edge_owner):
        edges = ground.edges[ground.edge_owner == owner]
        if distances_to_segments(corner, edges[:, :2], edges[:, 2:]).min() >= COVERED_M:
            return True
    return False
