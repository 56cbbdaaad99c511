"""A post whose every corner is blunt, and whose tip is sharp: a pointed arch of many corners."""

import math

import numpy as np

from world.geometry.shapes import Polygon

TURN_RAD = math.pi / 3.0
EDGES = 60  # of each arc


def pointed_arch(*, width_m: float, tip_m: float, bearing_rad: float) -> Polygon:
    """A triangle of three arcs, each around the corner opposite: equally wide in all directions.

    Its corners have 120 degrees and more, but from its tip its feet are seen at 60. The tip points at the
    origin, from this distance and bearing.

    Args:
        width_m: its width.
        tip_m: from the origin to its tip.
        bearing_rad: of the tip, from the origin.
    """
    feet = [width_m * np.array([math.cos(side), math.sin(side)]) for side in (-TURN_RAD / 2, TURN_RAD / 2)]
    tip, right, left = np.zeros(2), *feet
    ring = []
    for start, middle in ((tip, left), (right, tip), (left, right)):
        begin_rad = math.atan2(*(start - middle)[::-1])
        turned = begin_rad + np.arange(EDGES) * TURN_RAD / EDGES
        ring.append(middle + width_m * np.stack([np.cos(turned), np.sin(turned)], axis=1))
    places = np.vstack(ring) + np.array([tip_m, 0.0])
    cosine, sine = math.cos(bearing_rad), math.sin(bearing_rad)
    places = places @ np.array([[cosine, sine], [-sine, cosine]])
    return Polygon(vertices_m=tuple((float(x), float(y)) for x, y in places))
