"""How far one point that moves slowly is from the nearest obstacle; for single points faster than arrays.

Rule 1: the obstacles that may be nearest are looked for once, around an anchor. They serve while the point is
        near to it.
Rule 2: a point that is nearer to another than that one's clearance is outside all obstacles, as that one is.
        An anchor that touches an obstacle, or is inside it, serves for no other point.
Rule 3: what is kept follows from the ground alone, so it is true in every world on this ground.
"""

import math
from operator import itemgetter

import numpy as np

from world.geometry.clearance import clearance_at
from world.geometry.ellipses import NEWTON_STEPS
from world.geometry.shapes import Ground

REACH_M = 0.5  # a second of driving; in twice that there are a few obstacles
REACH_SHARE = 0.9  # of a clearance, for rule 2
ROUNDING_M = 1e-9  # an upper bound of the error of distances up to 1 km

Row = tuple[float, ...]


class Nearby:
    """The clearance of one point after the other; the same as by `clearance_at`, up to rounding."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self._x_m = self._y_m = math.nan
        self._reach_m = -1.0
        self._free_x_m = self._free_y_m = math.nan
        self._free_m = 0.0
        """The last point that was asked for, and its clearance."""
        self._rows: list[tuple[float, Row]] = []
        """What may be nearest, by how near to the anchor: circles (3 numbers), edges (4), ellipses (6)."""

    def clearance_m(self, x_m: float, y_m: float) -> float:
        """The distance of the point to any obstacle; inf without any."""
        dx, dy = x_m - self._x_m, y_m - self._y_m
        off_m = math.sqrt(dx * dx + dy * dy)
        if not off_m <= self._reach_m:
            return self._look_around(x_m, y_m)
        clear_m = self._least_m(x_m, y_m, off_m)
        self._free_x_m, self._free_y_m, self._free_m = x_m, y_m, clear_m
        return clear_m

    def _look_around(self, x_m: float, y_m: float) -> float:
        """Rule 1, with an anchor here."""
        ground, discs = self._ground, self._ground.discs
        is_outside = math.hypot(x_m - self._free_x_m, y_m - self._free_y_m) < REACH_SHARE * self._free_m
        self._x_m, self._y_m, self._reach_m = x_m, y_m, math.inf
        if len(discs) == 0:
            return math.inf
        x, y = discs[:, 0] - x_m, discs[:, 1] - y_m
        to_centres_m = np.sqrt(x * x + y * y)
        # An obstacle whose disc is further than what lies within another cannot be the nearest.
        bound_m = (to_centres_m - ground.inner_radii_m).min() + 2.0 * REACH_M + ROUNDING_M
        to_discs_m = to_centres_m - discs[:, 2] - ROUNDING_M
        near = np.flatnonzero(to_discs_m <= bound_m)
        self._rows = sorted(
            zip(to_discs_m[near].tolist(), map(self._row, near.tolist()), strict=True), key=itemgetter(0)
        )
        if is_outside:
            clear_m = self._least_m(x_m, y_m, 0.0)
        else:
            clear_m = float(clearance_at(ground, np.array([[x_m, y_m]]))[0])
        self._free_x_m, self._free_y_m, self._free_m = x_m, y_m, clear_m
        self._reach_m = min(REACH_M, REACH_SHARE * clear_m) if clear_m > ROUNDING_M else -1.0
        return clear_m

    def _row(self, disc: int) -> Row:
        """What one of the ground's discs is around."""
        ground = self._ground
        first_ellipse, first_edge = len(ground.circles), len(ground.circles) + len(ground.ellipses)
        if disc < first_ellipse:
            return tuple(ground.circles[disc].tolist())
        if disc >= first_edge:
            return tuple(ground.edges[disc - first_edge].tolist())
        x_m, y_m, a, b, rotation_rad = ground.ellipses[disc - first_ellipse].tolist()
        return x_m, y_m, a, b, math.cos(rotation_rad), math.sin(rotation_rad)

    def _least_m(self, x_m: float, y_m: float, off_m: float) -> float:
        """The distance of a point that is so far off the anchor, and outside all obstacles."""
        least_m = math.inf
        for near_m, row in self._rows:
            if near_m - off_m >= least_m:
                break  # all further ones are at least as far
            match len(row):
                case 3:
                    least_m = min(least_m, _to_circle_m(x_m, y_m, row))
                case 4:
                    least_m = min(least_m, _to_edge_m(x_m, y_m, row))
                case _:
                    least_m = min(least_m, _to_ellipse_m(x_m, y_m, row))
        return max(least_m, 0.0)


def _to_circle_m(x_m: float, y_m: float, circle: Row) -> float:
    centre_x, centre_y, radius_m = circle
    x, y = x_m - centre_x, y_m - centre_y
    return math.sqrt(x * x + y * y) - radius_m


def _to_edge_m(x_m: float, y_m: float, edge: Row) -> float:
    start_x, start_y, end_x, end_y = edge
    x, y, dx, dy = x_m - start_x, y_m - start_y, end_x - start_x, end_y - start_y
    share = min(max((x * dx + y * dy) / (dx * dx + dy * dy), 0.0), 1.0)
    x, y = x - share * dx, y - share * dy
    return math.sqrt(x * x + y * y)


def _to_ellipse_m(x_m: float, y_m: float, ellipse: Row) -> float:
    """As `world.geometry.ellipses.point_distances`."""
    centre_x, centre_y, a, b, cosine, sine = ellipse
    x, y = x_m - centre_x, y_m - centre_y
    x, y = abs(cosine * x + sine * y), abs(cosine * y - sine * x)
    if (x / a) ** 2 + (y / b) ** 2 <= 1.0:
        return 0.0
    ax, by, aa, bb = a * x, b * y, a * a, b * b
    t = max(ax - aa, by - bb, 0.0)
    for _ in range(NEWTON_STEPS):
        u, v = t + aa, t + bb
        p, q = ax / u, by / v
        pp, qq = p * p, q * q
        before, t = t, t + (pp + qq - 1.0) / (2.0 * (pp / u + qq / v))
        if t <= before:
            break
    return t * math.hypot(x / (t + aa), y / (t + bb))
