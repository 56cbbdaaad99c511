"""The monitor: clearance and separation along straight moves, from true poses.

Rule 1 (S1): every hull keeps `clearance_m_required` from every static obstacle, and stays inside the bounds.
Rule 2 (S1): a hull that drives is never in contact with a moving obstacle. A hull that stands, or turns on
        the spot, may be touched: the promise is passive.
Rule 3 (S2): every two hulls keep `separation_m_required`. They move at constant speed from start to end.
Rule 4: contact is always a violation, whatever distance is required. Robots with radius 0 are points.
Rule 5: a promise that stays broken is one violation, until it has been kept again.
"""

import math
from collections.abc import Iterator, Set
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from protocol.arrays import Floats, distances_to_segments
from protocol.mission import Bounds
from protocol.timeline import PromiseBroken
from world.geometry.clearance import clearance, separations
from world.geometry.movers import Movers
from world.geometry.shapes import Ground
from world.judge.moves import Intervals
from world.scenario.scenario import Scenario

Rows = NDArray[np.intp]
Topic = tuple[str, int, int | None]  # what is judged, the robot, and the other robot or obstacle

PAIR_SLACK_M = 2.0  # two bodies at 0.5 m/s: one second of look-ahead and one of motion
ROUNDING_M = 1e-9  # error of sums over ticks; far below any tolerance


@dataclass(frozen=True, slots=True, kw_only=True)
class Promises:
    """The distances that S1 and S2 require."""

    radius_m: float
    clearance_m_required: float
    separation_m_required: float
    bounds: Bounds | None

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """The promises of a scenario; a law that promises no clearance only promises no contact."""
        law = scenario.law
        kept_m = law.epsilon_m - law.mu0_m if law.promises_clearance else 0.0
        apart_m = max(scenario.fleet.separation_m - law.mu0_m, 0.0) if law.promises_clearance else 0.0
        return cls(
            radius_m=scenario.fleet.robot_radius_m,
            clearance_m_required=kept_m,
            separation_m_required=apart_m,
            bounds=scenario.bounds,
        )


class Least(Struct, frozen=True, kw_only=True):
    """The least distance so far, with robots and time; infinite if there is nothing to measure."""

    distance_m: float = math.inf
    t_s: float = 0.0
    robot: int | None = None
    other: int | None = None


@dataclass(slots=True)
class Monitor:
    """Watches simultaneous straight moves of all bodies. Robot k is row k - 1."""

    ground: Ground
    movers: Movers
    promises: Promises
    least_clearance: Least = field(default_factory=Least)
    least_separation: Least = field(default_factory=Least)
    least_moving_clearance: Least = field(default_factory=Least)
    """Of driving hulls to moving obstacles."""
    clearance_m: Floats = field(default_factory=lambda: np.empty(0))
    """Clearance of each hull in the last moves; below 0 inside an obstacle."""
    _watched_s: float = 0.0
    _moved: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    _pairs: tuple[Rows, Rows] = field(default_factory=lambda: (np.empty(0, np.intp), np.empty(0, np.intp)))
    _compared_m: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """The positions when all pairs were last compared."""
    _slack_m: float = 0.0
    """How much nearer than then two bodies can come before all pairs must be compared again."""
    _broken: set[Topic] = field(default_factory=set)

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """A monitor for the promises of a scenario."""
        return cls(scenario.ground, scenario.movers, Promises.of(scenario))

    def watch(
        self,
        starts_m: Floats,
        ends_m: Floats,
        *,
        t_s: float,
        clear_m: Floats | None = None,
        is_safe: bool = False,
    ) -> list[PromiseBroken]:
        """Judge the next moves, up to `t_s`; returns the violations that begin in them.

        Args:
            starts_m: (N, 2) [world frame].
            ends_m: likewise.
            t_s: simulated time.
            clear_m: (N,) the `clearance` of these moves, if it is already known.
            is_safe: whether they certainly keep all promises, except perhaps that of rule 2.
        """
        from_s, self._watched_s = self._watched_s, t_s
        moved = (starts_m != ends_m).any(axis=1)
        if is_safe:
            self._moved = moved
            nothing_new = not moved.any() and self.is_calm
            return [] if nothing_new else self._judge_contact(starts_m, ends_m, from_s, t_s)
        first = len(self.clearance_m) == 0
        if first:
            self.clearance_m = np.full(len(starts_m), math.inf)
        # A body that moved before and stands now may have been nearer on its way.
        stale = np.flatnonzero(np.ones_like(moved) if first else moved | self._moved)
        self._moved = moved
        if len(stale) == 0:
            return []
        if clear_m is None:
            stale_m = clearance(self.ground, starts_m[stale], ends_m[stale])
        else:
            stale_m = clear_m[stale]
        self.clearance_m[stale] = stale_m - self.promises.radius_m
        nearest = int(np.argmin(self.clearance_m))
        if self.clearance_m[nearest] < self.least_clearance.distance_m:
            self.least_clearance = Least(
                distance_m=float(self.clearance_m[nearest]), t_s=t_s, robot=nearest + 1
            )
        return [
            *self._judge_clearance(),
            *self._judge_contact(starts_m, ends_m, from_s, t_s),
            *self._judge_bounds(ends_m),
            *self._judge_pairs(starts_m, ends_m, t_s),
        ]

    def watch_all(self, intervals: Intervals) -> Iterator[tuple[float, PromiseBroken]]:
        """Judge moves interval by interval; returns the violations with the ends of their intervals."""
        is_calm = self._watch_calm(intervals)
        if is_calm and not self.movers.names:
            return
        for t_s, starts_m, ends_m, clear_m in zip(*intervals, strict=True):
            broken = self.watch(starts_m, ends_m, t_s=t_s, clear_m=clear_m, is_safe=is_calm)
            yield from ((t_s, each) for each in broken)

    def _watch_calm(self, intervals: Intervals) -> bool:
        """Judge all intervals at once if they break no promise; else do nothing. The result is the same.

        Contact with moving obstacles is left to be judged.
        """
        if not self.is_calm or len(self.clearance_m) == 0:
            return False
        ends_s, starts_m, ends_m, clear_m = intervals
        moved = (starts_m != ends_m).any(axis=2)
        stale = moved | np.concatenate((self._moved[np.newaxis], moved[:-1]))
        clearance_m = np.where(stale, clear_m - self.promises.radius_m, math.inf)
        one, other, apart_m = self._pairs_apart(starts_m, ends_m)
        if (
            _is_broken(clearance_m, self.promises.clearance_m_required).any()
            or (self._inside_m(ends_m) < -ROUNDING_M).any()
            or _is_broken(apart_m, self.promises.separation_m_required).any()
        ):
            return False
        if not self.movers.names:
            self._watched_s, self._moved = ends_s[-1], moved[-1]
        self.clearance_m = _newest(self.clearance_m, clearance_m)
        if clearance_m.min() < self.least_clearance.distance_m:
            when, row = divmod(int(clearance_m.argmin()), clearance_m.shape[1])
            self.least_clearance = Least(
                distance_m=float(clearance_m[when, row]), t_s=ends_s[when], robot=row + 1
            )
        if apart_m.min(initial=math.inf) < self.least_separation.distance_m:
            when, pair = divmod(int(apart_m.argmin()), apart_m.shape[1])
            self.least_separation = Least(
                distance_m=float(apart_m[when, pair]),
                t_s=ends_s[when],
                robot=int(one[pair]) + 1,
                other=int(other[pair]) + 1,
            )
        return True

    @property
    def is_calm(self) -> bool:
        """Whether no promise is broken now: then moves that certainly break none may be left out."""
        return not self._broken

    def _judge_clearance(self) -> list[PromiseBroken]:
        required_m = self.promises.clearance_m_required
        measured: dict[Topic, float] = {
            ("clearance", row + 1, None): float(self.clearance_m[row])
            for row in np.flatnonzero(_is_broken(self.clearance_m, required_m)).tolist()
        }
        why = "nearer to an obstacle than promised" if required_m > 0.0 else "touched an obstacle"
        return self._newly("S1", "clearance", measured, required_m, why)

    def _judge_contact(
        self, starts_m: Floats, ends_m: Floats, from_s: float, t_s: float
    ) -> list[PromiseBroken]:
        """Rule 2."""
        if not self.movers.names:
            return []
        apart_m = self._apart_from_movers_m(starts_m, ends_m, from_s, t_s)
        row = int(apart_m.min(axis=1).argmin())
        if apart_m[row].min() < self.least_moving_clearance.distance_m:
            self.least_moving_clearance = Least(distance_m=float(apart_m[row].min()), t_s=t_s, robot=row + 1)
        touching = np.argwhere(_is_broken(apart_m, 0.0)).tolist()
        begun = self._begun("contact", {("contact", row + 1, obstacle) for row, obstacle in touching})
        return [
            PromiseBroken(
                invariant="S1",
                robot=row + 1,
                measured_m=float(apart_m[row, obstacle]),
                required_m=0.0,
                why=f"in contact with moving obstacle {self.movers.names[obstacle]} while it moved",
            )
            for row, obstacle in touching
            if ("contact", row + 1, obstacle) in begun
        ]

    def _apart_from_movers_m(self, starts_m: Floats, ends_m: Floats, from_s: float, t_s: float) -> Floats:
        """The distance from each hull to each moving obstacle, `(N, K)`; inf for robots that stood."""
        apart_m = np.full((len(starts_m), len(self.movers.names)), math.inf)
        moved, radius_m = np.flatnonzero(self._moved), self.promises.radius_m
        if len(moved) > 0:
            near_m = radius_m + max(self.least_moving_clearance.distance_m, 0.0)
            approaches_m = self.movers.approaches_m(
                starts_m[moved], ends_m[moved], from_s=from_s, to_s=t_s, near_m=near_m
            )
            apart_m[moved] = approaches_m - radius_m
        return apart_m

    def _judge_bounds(self, ends_m: Floats) -> list[PromiseBroken]:
        inside_m = self._inside_m(ends_m)
        measured: dict[Topic, float] = {
            ("bounds", row + 1, None): float(inside_m[row])
            for row in np.flatnonzero(inside_m < -ROUNDING_M).tolist()
        }
        return self._newly("S1", "bounds", measured, 0.0, "out of bounds")

    def _inside_m(self, places_m: Floats) -> Floats:
        """The distance of each hull from the bounds (...,); negative outside."""
        bounds = self.promises.bounds
        if bounds is None:
            return np.full(places_m.shape[:-1], math.inf)
        low_m = places_m - (bounds.x_m_min, bounds.y_m_min)
        high_m = np.array((bounds.x_m_max, bounds.y_m_max)) - places_m
        inside_m: Floats = np.minimum(low_m, high_m).min(axis=-1) - self.promises.radius_m
        return inside_m

    def _judge_pairs(self, starts_m: Floats, ends_m: Floats, t_s: float) -> list[PromiseBroken]:
        required_m = self.promises.separation_m_required
        one, other, apart_m = self._pairs_apart(starts_m, ends_m)
        least = int(np.argmin(apart_m)) if len(apart_m) else None
        if least is not None and apart_m[least] < self.least_separation.distance_m:
            self.least_separation = Least(
                distance_m=float(apart_m[least]),
                t_s=t_s,
                robot=int(one[least]) + 1,
                other=int(other[least]) + 1,
            )
        measured: dict[Topic, float] = {
            ("separation", int(one[pair]) + 1, int(other[pair]) + 1): float(apart_m[pair])
            for pair in np.flatnonzero(_is_broken(apart_m, required_m)).tolist()
        }
        why = "two robots nearer than promised" if required_m > 0.0 else "two robots touched"
        return self._newly("S2", "separation", measured, required_m, why)

    def _pairs_apart(self, starts_m: Floats, ends_m: Floats) -> tuple[Rows, Rows, Floats]:
        """Pairs of hulls with their least distance during the moves; omitted pairs are far apart.

        The moves are (N, 2), or (T, N, 2) for several intervals.
        """
        one, other = self._near_pairs(starts_m, ends_m)
        # Relative to one body the other moves straight.
        nearest_m = distances_to_segments(
            np.zeros(2),
            starts_m[..., other, :] - starts_m[..., one, :],
            ends_m[..., other, :] - ends_m[..., one, :],
        )
        return one, other, nearest_m - 2 * self.promises.radius_m

    def _near_pairs(self, starts_m: Floats, ends_m: Floats) -> tuple[Rows, Rows]:
        """The pairs that may be nearer than the required or the least distance so far.

        All pairs are compared only when bodies may have moved far enough for other pairs to come near. The
        comparison is quadratic: 1000 bodies have half a million pairs.
        """
        if len(self._compared_m) == 0 or 2.0 * self._off_compared_m(starts_m, ends_m) > self._slack_m:
            self._compared_m = first_m = starts_m.reshape(-1, *starts_m.shape[-2:])[0]
            self._slack_m = PAIR_SLACK_M + 2.0 * self._off_compared_m(starts_m, ends_m)
            apart_m = separations(first_m, first_m) - 2 * self.promises.radius_m
            near_m = max(
                self.promises.separation_m_required, min(self.least_separation.distance_m, apart_m.min())
            )
            one, other = np.nonzero(np.triu(apart_m <= near_m + self._slack_m, k=1))
            self._pairs = (one, other)
        return self._pairs

    def _off_compared_m(self, starts_m: Floats, ends_m: Floats) -> float:
        """The largest distance of any body, at either end of its move, from its position compared then."""
        off_m = np.concatenate((starts_m - self._compared_m, ends_m - self._compared_m))
        return float(np.hypot(off_m[..., 0], off_m[..., 1]).max())

    def _newly(
        self,
        invariant: str,
        topic: str,
        measured: dict[Topic, float],
        required_m: float,
        why: str,
    ) -> list[PromiseBroken]:
        begun = self._begun(topic, measured.keys())
        return [
            PromiseBroken(
                invariant=invariant,
                robot=key[1],
                other=key[2],
                measured_m=distance_m,
                required_m=required_m,
                why=why,
            )
            for key, distance_m in measured.items()
            if key in begun
        ]

    def _begun(self, topic: str, broken: Set[Topic]) -> Set[Topic]:
        """The violations that begin now."""
        if not self._broken and not broken:
            return broken
        before = {key for key in self._broken if key[0] == topic}
        self._broken = (self._broken - before) | broken
        return broken - before


def _newest(known_m: Floats, measured_m: Floats) -> Floats:
    """For each body (N,) the newest of the distances (T, N) that is finite; else the known one."""
    is_measured = measured_m < math.inf
    newest = len(measured_m) - 1 - is_measured[::-1].argmax(axis=0)
    return np.where(is_measured.any(axis=0), measured_m[newest, np.arange(len(known_m))], known_m)


def _is_broken(distance_m: Floats, required_m: float) -> NDArray[np.bool_]:
    return (distance_m <= 0.0) | (distance_m < required_m - ROUNDING_M)
