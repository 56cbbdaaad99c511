"""Things to draw, for tools that show scenes: lines, discs and labels on the ground. Pure.

Each thing has a name; drawing it again replaces the earlier thing with that name.
"""

import math
from dataclasses import dataclass

import numpy as np

from protocol.arrays import unit_vectors
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape

Points = tuple[tuple[float, float], ...]
CORNERS = 48  # of a round outline: sides of 7.5 degrees look round


@dataclass(frozen=True, slots=True)
class Colour:
    """Red, green, blue and opacity, from 0 to 1."""

    r: float
    g: float
    b: float
    a: float = 1.0


@dataclass(frozen=True, slots=True)
class Stroke:
    """A line through points [m; the thing's frame]."""

    points: Points
    colour: Colour
    width_px: float = 2.0
    closed: bool = False


@dataclass(frozen=True, slots=True)
class Disc:
    """A filled disc [m; the thing's frame]."""

    centre: tuple[float, float]
    radius_m: float
    colour: Colour


@dataclass(frozen=True, slots=True)
class Label:
    """A label at a place [m; the thing's frame]."""

    at: tuple[float, float]
    text: str
    colour: Colour


@dataclass(frozen=True, slots=True)
class Thing:
    """Everything drawn under one name, in the world frame or in a robot's frame."""

    name: str
    marks: tuple[Stroke | Disc | Label, ...]
    robot: int | None = None
    """None: the world frame."""


def outline(shape: Shape, colour: Colour, at: tuple[float, float] = (0.0, 0.0)) -> Stroke:
    """The outline of a shape, moved to a place."""
    turn_rad = np.linspace(0.0, math.tau, CORNERS, endpoint=False)
    round_m = unit_vectors(turn_rad)
    match shape:
        case Circle(centre_m=centre_m, radius_m=radius_m):
            ring_m = centre_m + radius_m * round_m
        case Ellipse(centre_m=centre_m, semi_axes_m=semi_axes_m, rotation_rad=rotation_rad):
            cos, sin = math.cos(rotation_rad), math.sin(rotation_rad)
            ring_m = centre_m + (round_m * semi_axes_m) @ np.array([[cos, sin], [-sin, cos]])
        case Polygon():
            ring_m = shape.ring_m
    return Stroke(tuple(map(tuple, (ring_m + at).tolist())), colour, closed=True)


def capsule(start: tuple[float, float], end: tuple[float, float], radius_m: float, colour: Colour) -> Stroke:
    """The outline of all places within `radius_m` of the segment from `start` to `end`."""
    heading_rad = math.atan2(end[1] - start[1], end[0] - start[0])
    half = np.linspace(-math.pi / 2, math.pi / 2, CORNERS // 2)
    points: list[tuple[float, float]] = []
    for (x_m, y_m), from_rad in ((end, heading_rad), (start, heading_rad + math.pi)):
        points += [
            (x_m + radius_m * math.cos(from_rad + turn_rad), y_m + radius_m * math.sin(from_rad + turn_rad))
            for turn_rad in half.tolist()
        ]
    return Stroke(tuple(points), colour, closed=True)
