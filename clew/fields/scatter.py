"""Scatters obstacles over a rectangle [m; world frame], with a least gap between any two."""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from clew.fields.shapes import Draw, Obstacle, area_m2, extent, moved
from protocol.arrays import Floats
from world.geometry.clearance import clearance, distances
from world.geometry.shapes import Circle, Polygon, ground_of

TRIES = 200  # so many failures in a row mean that the field is full


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
    placed: list[Obstacle] = []
    covered_m2, in_vain = 0.0, 0
    while covered_m2 < density * size_m[0] * size_m[1] and in_vain < TRIES:
        drawn = draws[int(chance.integers(len(draws)))](chance, unit_m)
        obstacle = moved(drawn, chance.uniform((0.0, 0.0), size_m))
        if _is_inside(obstacle, size_m, least_width_m) and _is_apart(obstacle, placed, least_width_m):
            placed.append(obstacle)
            covered_m2 += area_m2(obstacle)
            in_vain = 0
        else:
            in_vain += 1
    return placed


def _is_inside(obstacle: Obstacle, size_m: tuple[float, float], least_width_m: float) -> bool:
    low, high = extent(obstacle)
    beside = np.array([0.0, least_width_m])
    return bool((low >= beside).all() and (high <= np.array(size_m) - beside).all())


def _is_apart(obstacle: Obstacle, placed: Sequence[Obstacle], least_width_m: float) -> bool:
    if least_width_m == 0.0:
        return True
    low, high = extent(obstacle)
    near = [
        other
        for other, (other_low, other_high) in ((other, extent(other)) for other in placed)
        if (np.maximum(other_low - high, low - other_high) < least_width_m).all()
    ]
    return not near or _apart_m(obstacle, near) >= least_width_m


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
