"""Clearance and separation against time, from true poses and by the functions that the monitor judges by.

Rule 1: a distance is the least since the time before, all along the straight moves in between.
Rule 2: where there are more than `CURVE_POINTS` of them, several become one, with the least and its time: a
        curve may lose detail, but never its lowest point.
Rule 3: a body that has not been sampled stands: the world samples one before it moves, and while it does at
        every odometry. So what is `HOLD_S` old is known of all.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from clew.story.tracks import ODOMETRY_PERIOD_S
from protocol.arrays import Floats, Indices, distances_to_segments
from world.geometry.clearance import clearance
from world.geometry.movers import Movers
from world.geometry.shapes import Ground

CURVE_POINTS = 60_000  # of one kind, in all: several for each pixel of a screen and robot
HOLD_S = 2 * ODOMETRY_PERIOD_S
INSTANTS_AT_ONCE = 32  # pairs that may be the nearest are chosen so often
MOVES_AT_ONCE = 2000  # so many judged against obstacles in one go: more need memory and save no time

Curve = tuple[Floats, Floats, Indices, Indices]
"""Times, least distances since the time before, robots, and the other robots or the moving obstacles."""


@dataclass(slots=True)
class Clearances:
    """How clear each hull was of what never moves."""

    ground: Ground
    radius_m: float
    least_m: float = math.inf
    """Of all hulls so far."""
    _last: dict[int, Floats] = field(default_factory=dict)
    _count: int = 0

    def along(self, robot: int, rows: Floats) -> tuple[Floats, Floats] | None:
        """The clearance of a body along these samples, (n, 4), with times; None: there is no obstacle."""
        if self.ground.shape_count == 0:
            return None
        places_m = rows[:, 1:3]
        before_m = self._last.get(robot, places_m[0])
        self._last[robot] = places_m[-1].copy()
        starts_m = np.vstack((before_m, places_m[:-1]))
        least_m = np.concatenate(
            [
                clearance(
                    self.ground, starts_m[part : part + MOVES_AT_ONCE], places_m[part : part + MOVES_AT_ONCE]
                )
                for part in range(0, len(rows), MOVES_AT_ONCE)
            ]
        )
        self._count += len(rows)
        kept = _lowest(least_m, self._count)
        least_m = least_m[kept] - self.radius_m
        self.least_m = min(self.least_m, float(least_m.min()))
        return rows[kept, 0], least_m


def _lowest(least_m: Floats, count: int) -> Indices:
    """Rule 2: the rows to keep, of `count` in all so far."""
    of_each = math.ceil(count / CURVE_POINTS)
    firsts = np.arange(0, len(least_m), of_each)
    if of_each == 1:
        return firsts
    padded = np.full(len(firsts) * of_each, math.inf)
    padded[: len(least_m)] = least_m
    rows: Indices = firsts + padded.reshape(-1, of_each).argmin(axis=1)
    return rows


@dataclass(slots=True)
class Separations:
    """The two hulls that are nearest to each other, and the moving obstacle that one passes nearest."""

    movers: Movers
    radius_m: float
    apart_m: float = math.inf
    """The least so far between two hulls."""
    passed_m: float = math.inf
    """The least so far between a hull that moved and a moving obstacle."""
    _samples: dict[int, Floats] = field(default_factory=dict)
    """(n, 3): what has not been looked at, and the newest that has."""
    _looked_s: float = -math.inf
    _count: int = 0

    def hear(self, robot: int, rows: Floats) -> None:
        """Take samples of a body in, (n, 4)."""
        before = self._samples.get(robot)
        self._samples[robot] = rows[:, :3] if before is None else np.vstack((before, rows[:, :3]))

    def since(self, *, ended: bool) -> tuple[Curve | None, Curve | None]:
        """Separations and passings since the last time."""
        if not self._samples:
            return None, None
        robots = sorted(self._samples)
        sampled_s = np.unique(np.concatenate([self._samples[robot][:, 0] for robot in robots]))
        until_s = sampled_s[-1] if ended else sampled_s[-1] - HOLD_S
        instants_s = sampled_s[(sampled_s >= self._looked_s) & (sampled_s <= until_s)]
        if len(instants_s) < 2:
            return None, None
        places_m = np.stack([_places(self._samples[robot], instants_s) for robot in robots], axis=1)
        names = np.array(robots)
        apart = list(_nearest_pairs(instants_s, places_m, names, self.radius_m))
        passed = list(self._passings(instants_s, places_m, names)) if self.movers.names else []
        self._forget(float(instants_s[-1]))
        self.apart_m = min([self.apart_m, *(float(least_m.min()) for _, least_m, _, _ in apart)])
        self.passed_m = min([self.passed_m, *(float(least_m.min()) for _, least_m, _, _ in passed)])
        return self._thinned(apart), self._thinned(passed)

    def _thinned(self, curves: list[Curve]) -> Curve | None:
        if not curves:
            return None
        t_s, least_m, robots, others = (np.concatenate(part) for part in zip(*curves, strict=True))
        self._count += len(t_s)
        rows = _lowest(least_m, self._count)
        return t_s[rows], least_m[rows], robots[rows], others[rows]

    def _forget(self, looked_s: float) -> None:
        self._looked_s = looked_s
        for robot, rows in self._samples.items():
            kept = max(int(np.searchsorted(rows[:, 0], looked_s, side="right")) - 1, 0)
            self._samples[robot] = rows[kept:]

    def _passings(self, instants_s: Floats, places_m: Floats, names: Indices) -> Iterator[Curve]:
        """Of each interval in which a body moved, the one that came nearest to a moving obstacle."""
        for row in range(1, len(instants_s)):
            starts_m, ends_m = places_m[row - 1], places_m[row]
            moved = np.flatnonzero((starts_m != ends_m).any(axis=1))
            if len(moved) == 0:
                continue
            from_s, to_s = float(instants_s[row - 1]), float(instants_s[row])
            apart_m = self.movers.approaches_m(
                starts_m[moved], ends_m[moved], from_s=from_s, to_s=to_s, near_m=math.inf
            )
            body, obstacle = np.unravel_index(int(np.argmin(apart_m)), apart_m.shape)
            least_m = apart_m[body, obstacle] - self.radius_m
            yield instants_s[row : row + 1], np.array([least_m]), names[[moved[body]]], np.array([obstacle])


def _places(rows: Floats, instants_s: Floats) -> Floats:
    """Where a body was at each instant, (n, 2)."""
    x, y = (np.interp(instants_s, rows[:, 0], rows[:, axis]) for axis in (1, 2))
    return np.column_stack((x, y))


def _nearest_pairs(instants_s: Floats, places_m: Floats, names: Indices, radius_m: float) -> Iterator[Curve]:
    """Of each interval the two bodies that come nearest to each other, hull to hull."""
    if places_m.shape[1] < 2:
        return
    for first in range(1, len(instants_s), INSTANTS_AT_ONCE):
        ends_m = places_m[first : first + INSTANTS_AT_ONCE]
        starts_m = places_m[first - 1 : first - 1 + len(ends_m)]
        one, other = _candidates(starts_m, ends_m)
        apart_m = distances_to_segments(
            np.zeros(2), starts_m[:, other] - starts_m[:, one], ends_m[:, other] - ends_m[:, one]
        )
        pair = np.argmin(apart_m, axis=1)
        least_m = apart_m[np.arange(len(pair)), pair] - 2 * radius_m
        yield instants_s[first : first + len(ends_m)], least_m, names[one[pair]], names[other[pair]]


def _candidates(starts_m: Floats, ends_m: Floats) -> tuple[Indices, Indices]:
    """The pairs of bodies that may be the nearest in some of these moves, in which none drives further."""
    driven_m = float(np.hypot(*np.moveaxis(ends_m - starts_m, -1, 0)).sum(axis=0).max())
    x, y = (np.subtract.outer(axis, axis) for axis in starts_m[0].T)
    apart_m = np.sqrt(x * x + y * y)
    one, other = np.triu_indices(len(apart_m), k=1)
    near = apart_m[one, other] <= apart_m[one, other].min() + 4 * driven_m
    return one[near], other[near]
