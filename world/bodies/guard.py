"""Finds that the moves of a tick certainly break no promise, at little cost; the monitor judges all others.

Rule 1 (S1): a body is in a free disc, or on a course that is known to be clear. Both follow from the ground
        alone.
Rule 2 (S2): a body that moves is compared with the bodies that stood near it when all pairs were compared.
        All pairs are compared again before any body has moved by half of `SLACK_M`, so the guard is asked at
        every tick. In a small fleet each body that moves is compared with all others: all pairs cost more.
Rule 3: in doubt moves are not safe: every limit includes rounding errors.
"""

import math

import numpy as np

from world.bodies.bodies import Bodies, Moves
from world.bodies.body import Body
from world.geometry.clearance import keep_off, separations
from world.geometry.nearby import Nearby
from world.geometry.shapes import Ground
from world.judge.monitor import Promises

SMALL_FLEET = 16
SLACK_M = 1.0  # two seconds of driving; twice that lists four times as many pairs
ROUNDING_M = 1e-9  # error of sums over ticks; far below any tolerance

Place = tuple[float, float]  # x, y [m; world frame]
Way = tuple[float, float, float, float]  # from x, y to x, y


class Guard:
    """Looks at the moves of all bodies, by row."""

    def __init__(self, promises: Promises, ground: Ground, robots: int) -> None:
        self._bounds = promises.bounds
        self._ground = ground
        self._nearby = [Nearby(ground) for _ in range(robots)]
        self._radius_m = promises.radius_m
        self._off_ground_m = promises.radius_m + promises.clearance_m_required + ROUNDING_M
        self._apart_m = 2.0 * promises.radius_m + promises.separation_m_required + ROUNDING_M
        rows = range(robots)
        self._free = [(0.0, 0.0, -1.0)] * robots
        """For each body a disc in which its centre breaks no promise of S1: x, y, radius."""
        self._clear: list[Way | None] = [None] * robots
        """The newest course of each body that is known to be clear."""
        self._near: list[list[int]] = [[other for other in rows if other != row] for row in rows]
        self._listed_m: list[Place] = []
        """Where all bodies were when the lists of those that are near were made; none in a small fleet."""

    def clearance_m(self, row: int, place: Place) -> float:
        """How far a body's centre would be from the nearest obstacle at this place."""
        return self._nearby[row].clearance_m(*place)

    def are_safe(self, bodies: Bodies, moves: Moves) -> bool:
        """Whether these moves certainly break no promise."""
        ways: dict[int, Way] = {}
        for row, start in moves.starts.items():
            body = bodies[row]
            if start.x_m != body.x_m or start.y_m != body.y_m:
                ways[row] = (start.x_m, start.y_m, body.x_m, body.y_m)
        if not ways:
            return True
        return self._are_listed(bodies, ways) and all(
            self._is_clear(row, way, bodies[row]) and self._keeps_apart(row, bodies, ways)
            for row, way in ways.items()
        )

    def _is_clear(self, row: int, way: Way, body: Body) -> bool:
        """Rule 1."""
        if _is_in(way, self._free[row]) or (course := body.course_m) == self._clear[row]:
            return True
        x_m, y_m, *_ = way
        free_m = min(self._nearby[row].clearance_m(x_m, y_m) - self._off_ground_m, self._inside_m(x_m, y_m))
        self._free[row] = (x_m, y_m, free_m)
        if _is_in(way, self._free[row]):
            return True
        ends = np.array([course])
        if self._inside_m(*course[2:]) > 0.0 and keep_off(
            self._ground, ends[:, :2], ends[:, 2:], self._off_ground_m
        ):
            self._clear[row] = course
            return True
        return False

    def _inside_m(self, x_m: float, y_m: float) -> float:
        """How far a body can go and stay inside the bounds."""
        bounds = self._bounds
        if bounds is None:
            return math.inf
        to_side_m = min(
            x_m - bounds.x_m_min, bounds.x_m_max - x_m, y_m - bounds.y_m_min, bounds.y_m_max - y_m
        )
        return to_side_m - self._radius_m - ROUNDING_M

    def _keeps_apart(self, row: int, bodies: Bodies, ways: dict[int, Way]) -> bool:
        """Rule 2."""
        from_x, from_y, to_x, to_y = ways[row]
        near_m = self._apart_m + (abs(to_x - from_x) + abs(to_y - from_y))
        for other in self._near[row]:
            way = ways.get(other)
            if way is None:
                body = bodies[other]
                then_x, then_y = now_x, now_y = body.x_m, body.y_m
                reach_m = near_m
            elif other < row:
                continue  # that body has been compared with this one
            else:
                then_x, then_y, now_x, now_y = way
                reach_m = near_m + abs(now_x - then_x) + abs(now_y - then_y)
            x, y = to_x - now_x, to_y - now_y
            if x * x + y * y > reach_m * reach_m:
                continue
            # Relative to the other body this one moves straight.
            if _to_origin_m(from_x - then_x, from_y - then_y, x, y) <= self._apart_m:
                return False
        return True

    def _are_listed(self, bodies: Bodies, ways: dict[int, Way]) -> bool:
        """Whether all that is near to these ways is listed; compares all pairs again where that helps."""
        if len(self._nearby) <= SMALL_FLEET or self._lists_serve(ways):
            return True
        places = bodies.places
        for row, way in ways.items():
            places[row] = way[:2]
        at_m = np.array(places)
        near = separations(at_m, at_m) <= self._apart_m + SLACK_M + ROUNDING_M
        self._near = [np.flatnonzero(row).tolist() for row in near]
        self._listed_m = places
        if self._lists_serve(ways):
            return True
        self._listed_m = []  # a body went too far, so that the lists are wrong in the next tick
        return False

    def _lists_serve(self, ways: dict[int, Way]) -> bool:
        """Rule 2; no list serves a body that drives further than half of `SLACK_M` in one tick."""
        listed_m = self._listed_m
        return bool(listed_m) and all(
            math.dist(listed_m[row], way[:2]) < SLACK_M / 2.0
            and math.dist(listed_m[row], way[2:]) < SLACK_M / 2.0
            for row, way in ways.items()
        )


def _is_in(way: Way, disc: tuple[float, float, float]) -> bool:
    from_x, from_y, to_x, to_y = way
    x_m, y_m, radius_m = disc
    return math.hypot(from_x - x_m, from_y - y_m) < radius_m and math.hypot(to_x - x_m, to_y - y_m) < radius_m


def _to_origin_m(from_x: float, from_y: float, to_x: float, to_y: float) -> float:
    """The distance of a segment from the origin."""
    dx, dy = to_x - from_x, to_y - from_y
    square = dx * dx + dy * dy
    share = min(max(-(from_x * dx + from_y * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(from_x + share * dx, from_y + share * dy)
