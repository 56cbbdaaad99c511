"""Scatters obstacles over a rectangle [m; world frame], with a least gap between any two."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from clew.fields.shapes import Draw, Obstacle, area_m2, extent, moved
from protocol.arrays import Floats
from world.geometry.clearance import clearance, distances
from world.geometry.shapes import Circle, Polygon, ground_of

TRIES = 200  # so many failures in a row mean that the field is full


class _Placed(NamedTuple):
    obstacle: Obstacle
    low: Floats
    high: Floats


def scatter(
    draws: Sequence[Draw],
    chance: Generator,
    *,
    size_m: tuple[float, float],
    density: float,
    least_width_m: float,
    unit_m: float,
) -> list[Obstacle]:
    """Obstacles in a rectangle at the origin, until they cover their share or no more fit.

    Args:
        draws: the shapes to choose from.
        chance: the source of all draws.
        size_m: size of the rectangle.
        density: share of it to cover.
        least_width_m: gap between obstacles, and to the sides along x; 0: they may overlap.
        unit_m: unit of the sizes of shapes.
    """
    placed: list[_Placed] = []
    beside = np.array([0.0, least_width_m])
    covered_m2, in_vain = 0.0, 0
    while covered_m2 < density * size_m[0] * size_m[1] and in_vain < TRIES:
        drawn = draws[int(chance.integers(len(draws)))](chance, unit_m)
        by_m = chance.uniform((0.0, 0.0), size_m)
        low, high = extent(drawn, by_m)
        in_vain += 1
        # This comes first: most drawn ones are not inside, and making an obstacle takes longer.
        if (low >= beside).all() and (high <= size_m - beside).all():
            one = _Placed(moved(drawn, by_m), low, high)
            if _is_apart(one, placed, least_width_m):
                placed.append(one)
                covered_m2 += area_m2(one.obstacle)
                in_vain = 0
    return [each.obstacle for each in placed]


def _is_apart(one: _Placed, placed: Sequence[_Placed], least_width_m: float) -> bool:
    if least_width_m == 0.0:
        return True
    near = [
        other.obstacle
        for other in placed
        if (np.maximum(other.low - one.high, one.low - other.high) < least_width_m).all()
    ]
    return not near or _apart_m(one.obstacle, near) >= least_width_m


def _apart_m(obstacle: Obstacle, others: Sequence[Obstacle]) -> float:
    """The distance to the nearest of the others; 0 or less where they overlap."""
    ground = ground_of(others)
    match obstacle:
        case Circle():
            return float(distances(ground, np.array(obstacle.centre_m)).min()) - obstacle.radius_m
        case Polygon():
            ring, itself = obstacle.ring_m, ground_of([obstacle])
            if any(distances(itself, _point_of(other))[0] == 0.0 for other in others):
                return 0.0  # one of them is inside, far from every edge
            return float(clearance(ground, ring, np.roll(ring, -1, axis=0)).min())


def _point_of(obstacle: Obstacle) -> Floats:
    return np.array(obstacle.centre_m if isinstance(obstacle, Circle) else obstacle.vertices_m[0])
