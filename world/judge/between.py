"""The monitor between fleets: no two hulls of different fleets touch, from true poses. Pure.

Rule 1: in one tick each body moves straight at constant speed, so seen from another body it moves straight.
Rule 2: contact is a violation, once for each pair of robots.
Rule 3: pairs are compared again only when bodies may have come nearer than the least distance so far.
"""

import math
from collections.abc import Mapping

import numpy as np
from msgspec import Struct

from protocol.arrays import Floats, distances_to_segments


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
        self._spare_m = 0.0
        """How much nearer two bodies must come before the least distance can change."""

    def watch(self, starts_m: Floats, ends_m: Floats, *, t_s: float) -> list[Encounter]:
        """Judge the next moves of all bodies, (n, 2) [world frame], up to `t_s`; returns new contacts."""
        self._spare_m -= 2.0 * float(np.hypot(*(ends_m - starts_m).T).max(initial=0.0))
        if self._spare_m > 0.0:
            return []
        one, other = self._one, self._other
        nearest_m = distances_to_segments(
            np.zeros(2), starts_m[other] - starts_m[one], ends_m[other] - ends_m[one]
        )
        hulls_m = nearest_m - self._reach_m
        pair = int(np.argmin(hulls_m))
        if self.least is None or hulls_m[pair] < self.least.distance_m:
            self.least = self._encounter(pair, hulls_m, t_s)
        ends_apart_m = np.hypot(*(ends_m[other] - ends_m[one]).T) - self._reach_m
        self._spare_m = float(ends_apart_m.min()) - max(self.least.distance_m, 0.0)
        return self._touch(np.flatnonzero(hulls_m <= 0.0).tolist(), hulls_m, t_s)

    def _touch(self, pairs: list[int], hulls_m: Floats, t_s: float) -> list[Encounter]:
        new = [self._encounter(pair, hulls_m, t_s) for pair in pairs if pair not in self._touched]
        self._touched.update(pairs)
        self.contacts += new
        return new

    def _encounter(self, pair: int, hulls_m: Floats, t_s: float) -> Encounter:
        (fleet, robot), (other_fleet, other) = self._who[self._one[pair]], self._who[self._other[pair]]
        distance_m = float(hulls_m[pair])
        assert math.isfinite(distance_m), "bodies have places"
        return Encounter(
            distance_m=distance_m,
            t_s=t_s,
            fleet=fleet,
            robot=robot,
            other_fleet=other_fleet,
            other=other,
        )
