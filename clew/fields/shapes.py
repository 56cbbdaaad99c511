"""The shapes that the field generator draws, each around the origin [m], with sizes in a unit.

No corner is sharper than about 30 degrees and nothing is thinner than half a unit, because a scan is less
certain near sharp corners and thin parts.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from protocol.arrays import Floats, unit_vectors
from world.geometry.shapes import Circle, Polygon

DECIMALS = 3  # of a coordinate in metres: fine enough to build, and the same on every machine
SIZE_UNITS = (0.5, 3.0)  # from half the size of the robot to three times its size
LEAST_AXES = 0.35  # shorter axis of an ellipse divided by the longer; flatter ones are too sharp
ELLIPSE_CORNERS = 24
CONVEX_CORNERS = (3, 8)
JITTER = 0.25  # share of the way to the next corner; keeps triangles above 30 degrees
ARM_UNITS = (0.5, 1.0)  # thickness of the arms of an L, a U or a comb
ARMS_LONG = (3.0, 6.0)  # length of the arms, in their thickness
STAR_TIPS = (3, 6)
STAR_NOTCHES = (0.6, 0.85)  # radius, as a share of that of a straight side; deeper is too sharp
COMB_TEETH = (3, 4)

Obstacle = Circle | Polygon
"""The shapes that a scene file can have."""

Draw = Callable[[Generator, float], Obstacle]
"""Draws a shape around the origin with a unit [m]."""


def circle(chance: Generator, unit_m: float) -> Obstacle:
    """A post."""
    return Circle(centre_m=(0.0, 0.0), radius_m=round(unit_m * chance.uniform(*SIZE_UNITS), DECIMALS))


def ellipse(chance: Generator, unit_m: float) -> Obstacle:
    """An ellipse as an inscribed polygon, because a scene file has no ellipses."""
    longer_m = unit_m * chance.uniform(2.0 * SIZE_UNITS[0], SIZE_UNITS[1])
    shorter_m = longer_m * chance.uniform(LEAST_AXES, 1.0)
    bearings = np.arange(ELLIPSE_CORNERS) * (math.tau / ELLIPSE_CORNERS)
    return _turned(np.stack([longer_m * np.cos(bearings), shorter_m * np.sin(bearings)], axis=1), chance)


def convex(chance: Generator, unit_m: float) -> Obstacle:
    """A polygon with its corners on a circle."""
    corners = int(chance.integers(CONVEX_CORNERS[0], CONVEX_CORNERS[1] + 1))
    shares = np.arange(corners) + chance.uniform(-JITTER, JITTER, corners)
    bearings = shares * (math.tau / corners)
    radius_m = unit_m * chance.uniform(2.0 * SIZE_UNITS[0], SIZE_UNITS[1])
    return _turned(radius_m * unit_vectors(bearings), chance)


def star(chance: Generator, unit_m: float) -> Obstacle:
    """Tips and notches by turns."""
    tips = int(chance.integers(STAR_TIPS[0], STAR_TIPS[1] + 1))
    radius_m = unit_m * chance.uniform(3.0 * SIZE_UNITS[0], SIZE_UNITS[1])
    inner_m = radius_m * math.cos(math.pi / tips) * chance.uniform(*STAR_NOTCHES)
    bearings = np.arange(2.0 * tips) * (math.pi / tips)
    radii_m = np.where(np.arange(2 * tips) % 2 == 0, radius_m, inner_m)[:, None]
    return _turned(radii_m * unit_vectors(bearings), chance)


def angle(chance: Generator, unit_m: float) -> Obstacle:
    """An L."""
    thick_m, long_m, deep_m = _arms(chance, unit_m)
    ring = [
        (0.0, 0.0),
        (long_m, 0.0),
        (long_m, thick_m),
        (thick_m, thick_m),
        (thick_m, deep_m),
        (0.0, deep_m),
    ]
    return _turned(np.array(ring), chance)


def pocket(chance: Generator, unit_m: float) -> Obstacle:
    """A U, which is a dead end."""
    return _comb(chance, unit_m, teeth=2)


def comb(chance: Generator, unit_m: float) -> Obstacle:
    """A back with teeth."""
    return _comb(chance, unit_m, teeth=int(chance.integers(COMB_TEETH[0], COMB_TEETH[1] + 1)))


DRAWS: dict[str, tuple[Draw, ...]] = {
    "circles": (circle,),
    "ellipses": (ellipse,),
    "convex": (convex,),
    "nonconvex": (angle, pocket, star, comb),
    "stars": (star,),
    "mixed": (circle, ellipse, convex, angle, pocket, star, comb),
}
"""The shapes of each kind of field."""


def _comb(chance: Generator, unit_m: float, *, teeth: int) -> Obstacle:
    thick_m, apart_m, deep_m = _arms(chance, unit_m)
    apart_m /= teeth - 1
    ring = [(0.0, 0.0), ((teeth - 1) * (thick_m + apart_m) + thick_m, 0.0)]
    for tooth in reversed(range(teeth)):
        left_m = tooth * (thick_m + apart_m)
        ring += [(left_m + thick_m, deep_m), (left_m, deep_m)]
        if tooth > 0:
            ring += [(left_m, thick_m), (left_m - apart_m, thick_m)]
    return _turned(np.array(ring), chance)


def _arms(chance: Generator, unit_m: float) -> tuple[float, float, float]:
    """Thickness, and the lengths of two arms."""
    thick_m = unit_m * chance.uniform(*ARM_UNITS)
    first, second = chance.uniform(*ARMS_LONG, 2)
    return thick_m, thick_m * float(first), thick_m * float(second)


def _turned(ring: Floats, chance: Generator) -> Polygon:
    """A ring around its middle, turned at random."""
    bearing_rad = chance.uniform(-math.pi, math.pi)
    cosine, sine = math.cos(bearing_rad), math.sin(bearing_rad)
    turned = (ring - ring.mean(axis=0)) @ np.array([[cosine, sine], [-sine, cosine]])
    return polygon(turned)


def polygon(ring: Floats) -> Polygon:
    """A polygon with rounded coordinates."""
    return Polygon(vertices_m=tuple((x, y) for x, y in np.round(ring, DECIMALS).tolist()))


def moved(obstacle: Obstacle, by_m: Floats) -> Obstacle:
    """The obstacle moved, with rounded coordinates."""
    match obstacle:
        case Circle():
            x_m, y_m = np.round(np.array(obstacle.centre_m) + by_m, DECIMALS).tolist()
            return Circle(centre_m=(x_m, y_m), radius_m=obstacle.radius_m)
        case Polygon():
            return polygon(obstacle.ring_m + by_m)


def extent(obstacle: Obstacle, by_m: Floats | float = 0.0) -> tuple[Floats, Floats]:
    """The least and the greatest x and y of the obstacle, moved by `by_m`."""
    match obstacle:
        case Circle():
            centre = np.round(np.array(obstacle.centre_m) + by_m, DECIMALS)
            return centre - obstacle.radius_m, centre + obstacle.radius_m
        case Polygon():
            ring = np.round(obstacle.ring_m + by_m, DECIMALS)
            return ring.min(axis=0), ring.max(axis=0)


def area_m2(obstacle: Obstacle) -> float:
    """Its area."""
    match obstacle:
        case Circle():
            return math.pi * obstacle.radius_m**2
        case Polygon():
            x, y = obstacle.ring_m.T
            return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0
