"""Scatters obstacles over a rectangle [m; world frame], with a least gap between any two."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

from clew.fields.shapes import Draw, Obstacle, area_m2, extent, moved
from protocol.arrays import Floats
from world.geometry.clearance import clearance, distances
from world.geometry.shapes import Circle, Polygon, ground_of
from world.scenario.scenario import OBSTACLES_MAX

TRIES = 200  # so many failures in a row mean that the field is full


@dataclass(slots=True)
class _Placed:
    """The obstacles so far, and the corners of the boxes around them (n, 2)."""

    obstacles: list[Obstacle] = field(default_factory=list)
    low: Floats = field(default_factory=lambda: np.empty((0, 2)))
    high: Floats = field(default_factory=lambda: np.empty((0, 2)))

    def near(self, low: Floats, high: Floats, within_m: float) -> list[Obstacle]:
        """The obstacles whose boxes are nearer than this to another box, along both axes."""
        beside_m = np.maximum(self.low - high, low - self.high)
        return [self.obstacles[row] for row in np.flatnonzero((beside_m < within_m).all(axis=1))]

    def add(self, obstacle: Obstacle, low: Floats, high: Floats) -> None:
        """Place one more."""
        self.obstacles.append(obstacle)
        self.low, self.high = np.vstack([self.low, low]), np.vstack([self.high, high])


def scatter(
    draws: Sequence[Draw],
    chance: Generator,
    *,
    size_m: tuple[float, float],
    density: float,
    least_width_m: float,
    unit_m: float,
) -> list[Obstacle]:
    """Obstacles in a rectangle at the origin, until they cover their share, or no more fit or are allowed.

    Args:
        draws: the shapes to choose from.
        chance: the source of all draws.
        size_m: size of the rectangle.
        density: share of it to cover.
        least_width_m: gap between obstacles, and to the sides along x; 0: they may overlap.
        unit_m: unit of the sizes of shapes.
    """
    placed = _Placed()
    beside = np.array([0.0, least_width_m])
    covered_m2, in_vain = 0.0, 0
    to_cover_m2 = density * size_m[0] * size_m[1]
    while covered_m2 < to_cover_m2 and in_vain < TRIES and len(placed.obstacles) < OBSTACLES_MAX:
        drawn = draws[int(chance.integers(len(draws)))](chance, unit_m)
        by_m = chance.uniform((0.0, 0.0), size_m)
        low, high = extent(drawn, by_m)
        in_vain += 1
        # This comes first: most drawn ones are not inside, and making an obstacle takes longer.
        if (low >= beside).all() and (high <= size_m - beside).all():
            one = moved(drawn, by_m)
            near = placed.near(low, high, least_width_m) if least_width_m > 0.0 else []
            if not near or _apart_m(one, near) >= least_width_m:
                placed.add(one, low, high)
                covered_m2 += area_m2(one)
                in_vain = 0
    return placed.obstacles


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
