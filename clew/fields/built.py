"""Ground that is built and not scattered: what a builder returns, and the parts that builders share."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from clew.fields.shapes import DECIMALS
from protocol.arrays import Floats, unit_vectors

Corner = tuple[float, float]
Ring = list[Corner]


@dataclass(frozen=True, slots=True, kw_only=True)
class Built:
    """Obstacles, and where the fleet comes in and has to go [m; world frame].

    The ground begins at the origin; the scene has walls below y = 0 and above its height.
    """

    size_m: tuple[float, float]
    walls: list[Ring] = field(default_factory=list)
    pillars: list[tuple[float, float, float]] = field(default_factory=list)
    """x, y, radius."""
    entrance_y_m: float
    exit_y_m: float = 0.0
    goal_m: Corner | None = None
    """On the ground; None: in the lane on the right, at `exit_y_m`."""


def rectangle(left_m: float, right_m: float, low_m: float, high_m: float) -> Ring:
    """A rectangle, anti-clockwise, with rounded coordinates."""
    return rounded([(left_m, low_m), (right_m, low_m), (right_m, high_m), (left_m, high_m)])


def rounded(corners: Sequence[Corner] | Floats) -> Ring:
    """Corners with rounded coordinates."""
    return [(round(float(x_m), DECIMALS), round(float(y_m), DECIMALS)) for x_m, y_m in corners]


def cells_of(size_m: tuple[float, float], side_m: float, wall_m: float) -> tuple[int, int]:
    """Columns and rows of cells that fit; the walls along the long sides are outside the ground."""
    pitch_m = side_m + wall_m
    return int((size_m[0] - wall_m) / pitch_m), int((size_m[1] + wall_m) / pitch_m)


def arc(
    centre: Floats, radius_m: float, from_rad: float, to_rad: float, *, facet_m: float, outside: bool
) -> Floats:
    """The corners of an arc with chords of that length or longer, which do not cross the circle.

    Args:
        centre: of the circle.
        radius_m: of the circle.
        from_rad: where the arc begins.
        to_rad: where it ends.
        facet_m: half the thickness of a wall; at its end, the world takes shorter ones for a thin part.
        outside: on which side of the circle the chords run.
    """
    count = max(int(abs(to_rad - from_rad) * radius_m / facet_m), 1)
    bearings_rad = np.linspace(from_rad, to_rad, count + 1)
    reach_m = radius_m / np.cos((to_rad - from_rad) / count / 2.0) if outside else radius_m
    return np.asarray(centre + reach_m * unit_vectors(bearings_rad))
