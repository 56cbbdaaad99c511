"""Round ground, with the goal in its middle: rings with one gate each, and a spiral.

The fleet can drive around the outermost wall, and all ways are at least one width wide.
"""

import math

import numpy as np
from numpy.random import Generator

from clew.fields.built import Built, arc, rounded
from protocol.arrays import Floats


def rings(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """Walls round each other, with a gate in each; between two of them runs a ring road."""
    side_m, middle = _square(size_m)
    walls = []
    outer_m = side_m / 2.0 - width_m
    while outer_m - wall_m > width_m:
        inner_m, gate_rad = outer_m - wall_m, chance.uniform(-math.pi, math.pi)
        half_rad = math.asin(width_m / 2.0 / inner_m)
        from_rad, to_rad = gate_rad + half_rad, gate_rad + math.tau - half_rad
        outline = arc(middle, outer_m, from_rad, to_rad, facet_m=wall_m / 2.0, outside=False)
        inline = arc(middle, inner_m, to_rad, from_rad, facet_m=wall_m / 2.0, outside=True)
        walls.append(rounded(np.vstack([outline, inline])))
        outer_m = inner_m - width_m
    return Built(
        size_m=(side_m, side_m), walls=walls, entrance_y_m=side_m / 2.0, goal_m=(side_m / 2.0, side_m / 2.0)
    )


def spiral(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """One wall of half circles around two centres by turns, so the way in has one width."""
    side_m, middle = _square(size_m)
    half_wall_m, pitch_m = wall_m / 2.0, width_m + wall_m
    outline, inline = [], []
    radius_m, centre, left = side_m / 2.0 - width_m - half_wall_m, np.zeros(2), False
    while radius_m > pitch_m * 0.75:  # the innermost half circle has room for the goal
        turn_rad = (math.pi, math.tau) if left else (0.0, math.pi)
        outline.append(arc(centre, radius_m + half_wall_m, *turn_rad, facet_m=half_wall_m, outside=False))
        inline.append(arc(centre, radius_m - half_wall_m, *turn_rad, facet_m=half_wall_m, outside=True))
        goal = centre
        centre = np.array([0.0 if left else -pitch_m / 2.0, 0.0])
        radius_m, left = radius_m - pitch_m / 2.0, not left
    bearing_rad, mirror = chance.uniform(-math.pi, math.pi), float(chance.choice([-1.0, 1.0]))
    turned = _turn(np.vstack([_joined(outline), _joined(inline)[::-1], goal[None, :]]), bearing_rad, mirror)
    *wall, goal_m = rounded(turned + middle)
    return Built(size_m=(side_m, side_m), walls=[wall], entrance_y_m=side_m / 2.0, goal_m=goal_m)


def _square(size_m: tuple[float, float]) -> tuple[float, Floats]:
    side_m = min(size_m)
    return side_m, np.full(2, side_m / 2.0)


def _joined(arcs: list[Floats]) -> Floats:
    """Arcs that begin where the one before ends, without the corners that would be there twice."""
    return np.vstack([arcs[0], *(each[1:] for each in arcs[1:])])


def _turn(corners: Floats, bearing_rad: float, mirror: float) -> Floats:
    cosine, sine = math.cos(bearing_rad), math.sin(bearing_rad)
    return np.asarray(corners * np.array([1.0, mirror]) @ np.array([[cosine, sine], [-sine, cosine]]))
