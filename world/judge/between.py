"""The monitor between fleets: no two hulls of different fleets touch, from true poses. Pure.

Rule 1: in one tick each body moves straight at constant speed, so seen from another body it moves straight.
Rule 2: contact is a violation, once for each pair of robots.
Rule 3: pairs are compared again only when bodies may have come nearer than the least distance so far; and
        of all pairs only those that were near lately: 1,000 robots in 200 fleets have half a million pairs.
"""

import math
from collections.abc import Mapping

import numpy as np
from msgspec import Struct

from protocol.arrays import Floats, Indices, distances_to_segments

LOOK_AHEAD_M = 2.0  # two bodies at 0.5 m/s come so much nearer in two seconds: a hundred ticks


class Encounter(Struct, frozen=True, kw_only=True):
    """Two robots of different fleets, and how near their hulls came."""

    distance_m: float
    t_s: float
    fleet: str
    robot: int
    other_fleet: str
    other: int

    def __str__(self) -> str:
        return (
            f"robot {self.robot} of {self.fleet} and robot {self.other} of {self.other_fleet}: "
            f"{self.distance_m:.4f} m at t={self.t_s:.2f} s"
        )


class Between:
    """Watches simultaneous straight moves of the bodies of all fleets."""

    def __init__(self, fleets: Mapping[str, tuple[int, float]]) -> None:
        """Watch these fleets: by name, how many robots, and their radius [m]."""
        self.least: Encounter | None = None
        """The nearest encounter; None before the first look."""
        self.contacts: list[Encounter] = []
        """The first contact of each pair that has touched."""
        self._who = [(name, robot) for name, (robots, _) in fleets.items() for robot in range(1, robots + 1)]
        rows = np.repeat(np.arange(len(fleets)), [robots for robots, _ in fleets.values()])
        self._one, self._other = np.nonzero(np.triu(rows[:, None] != rows, k=1))
        radii_m = np.repeat([radius_m for _, radius_m in fleets.values()], [n for n, _ in fleets.values()])
        self._reach_m: Floats = radii_m[self._one] + radii_m[self._other]
        self._touched: set[int] = set()
        self._near: Indices = np.empty(0, np.intp)
        """The pairs that were near when all were compared last."""
        self._far_m = 0.0
        """How much nearer two bodies of another pair must come before the least distance can change."""
        self._spare_m = 0.0
        """The same of all pairs."""

    def watch(self, starts_m: Floats, ends_m: Floats, *, t_s: float) -> list[Encounter]:
        """Judge the next moves of all bodies, (n, 2) [world frame], up to `t_s`; returns new contacts."""
        nearer_m = 2.0 * float(np.hypot(*(ends_m - starts_m).T).max(initial=0.0))
        self._spare_m -= nearer_m
        self._far_m -= nearer_m
        if self._spare_m > 0.0:
            return []
        if self._far_m <= 0.0:
            self._compare_all(starts_m, nearer_m)
        one, other = self._one[self._near], self._other[self._near]
        nearest_m = distances_to_segments(
            np.zeros(2), starts_m[other] - starts_m[one], ends_m[other] - ends_m[one]
        )
        hulls_m = nearest_m - self._reach_m[self._near]
        if len(hulls_m) > 0:
            row = int(np.argmin(hulls_m))
            if self.least is None or hulls_m[row] < self.least.distance_m:
                self.least = self._encounter(int(self._near[row]), float(hulls_m[row]), t_s)
        ends_apart_m = np.hypot(*(ends_m[other] - ends_m[one]).T) - self._reach_m[self._near]
        self._spare_m = min(self._far_m, float(ends_apart_m.min(initial=math.inf)) - self._least_m)
        return self._touch(np.flatnonzero(hulls_m <= 0.0).tolist(), hulls_m, t_s)

    @property
    def _least_m(self) -> float:
        """The least distance so far, or 0: a pair that touches after another is a contact, too."""
        return math.inf if self.least is None else max(self.least.distance_m, 0.0)

    def _compare_all(self, starts_m: Floats, nearer_m: float) -> None:
        """Find the pairs that may come near in a move that brings none nearer than this, or soon after."""
        hulls_m = np.hypot(*(starts_m[self._other] - starts_m[self._one]).T) - self._reach_m
        near_m = min(self._least_m, max(float(hulls_m.min()), 0.0)) + LOOK_AHEAD_M + nearer_m
        self._near = np.flatnonzero(hulls_m <= near_m)
        self._far_m = LOOK_AHEAD_M

    def _touch(self, rows: list[int], hulls_m: Floats, t_s: float) -> list[Encounter]:
        """The new contacts among these rows of the pairs that are near."""
        pairs = {int(self._near[row]): float(hulls_m[row]) for row in rows}
        new = [
            self._encounter(pair, each_m, t_s) for pair, each_m in pairs.items() if pair not in self._touched
        ]
        self._touched.update(pairs)
        self.contacts += new
        return new

    def _encounter(self, pair: int, distance_m: float, t_s: float) -> Encounter:
        (fleet, robot), (other_fleet, other) = self._who[self._one[pair]], self._who[self._other[pair]]
        assert math.isfinite(distance_m), "bodies have places"
        return Encounter(
            distance_m=distance_m,
            t_s=t_s,
            fleet=fleet,
            robot=robot,
            other_fleet=other_fleet,
            other=other,
        )
