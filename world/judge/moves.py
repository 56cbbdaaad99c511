"""The simultaneous straight moves of all bodies, from their samples; S1 and S2 are judged by them.

Rule 1: between two samples a body moved straight at constant speed. So the samples of all bodies divide the
        run into intervals in which all bodies did.
Rule 2: a body that stands is not sampled. So an interval is certain once the world's clock is `LAG_S` beyond
        it: the world samples moving bodies several times a second, so one that has no sample by then stood.
"""

from bisect import bisect_right, insort
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from protocol.arrays import Floats
from protocol.timeline import PoseSampled
from world.geometry.clearance import clearance
from world.geometry.shapes import Ground

LAG_S = 5.0  # the world samples a moving body every 0.1 s; a resumed world leaves out a second
MOVES_AT_ONCE = 1000  # moves judged against obstacles in one call: more need memory and save no time


class Intervals(NamedTuple):
    """Some intervals of N bodies, one after the other."""

    ends_s: list[float]
    """(T,), the time at which each interval ends."""
    starts_m: Floats
    """(T, N, 2) [world frame]."""
    ends_m: Floats
    """(T, N, 2) [world frame]."""
    clear_m: Floats
    """(T, N), the clearance of the ways from obstacles."""


class Moves:
    """Samples in, intervals out; keeps what the last `LAG_S` need."""

    def __init__(self, ground: Ground, robots: int, *, at_once: int = MOVES_AT_ONCE) -> None:
        self._ground = ground
        self._samples: list[list[tuple[float, float, float]]] = [[] for _ in range(robots)]
        """Of each body: time, x, y; the first is the newest one that is not after the last interval."""
        self._instants_s: list[float] = []
        """Times of samples after the last interval."""
        self._ends_m: Floats | None = None
        """Where the last interval ended; None: there was none."""
        self._ended_s = 0.0
        self._at_once = max(at_once // robots, 1)
        """How many intervals are made in one call."""
        self._unplaced = robots

    def __len__(self) -> int:
        return len(self._instants_s) * len(self._samples)

    @property
    def unplaced(self) -> Sequence[int]:
        """The robots whose bodies were not sampled where others were: until then no move is certain."""
        if self._unplaced == len(self._samples):
            return ()
        return [robot for robot, samples in enumerate(self._samples, start=1) if not samples]

    def hear(self, t_s: float, pose: PoseSampled) -> Iterator[Intervals]:
        """Process a sample; returns the intervals that are certain now, some at a time.

        The first one has no motion: it is the initial placement.
        """
        if not 0 < pose.robot <= len(self._samples):
            return
        samples = self._samples[pose.robot - 1]
        self._unplaced -= not samples
        last = samples[-1] if samples else None
        if last is not None and last[0] < self._ended_s and last[1:] != (pose.x_m, pose.y_m):
            samples.append((self._ended_s, *last[1:]))  # rule 2: it was held to stand until then
        samples.append((t_s, pose.x_m, pose.y_m))
        if (self._ends_m is None or t_s > self._ended_s) and t_s not in self._instants_s[-1:]:
            insort(self._instants_s, t_s)
        if self._unplaced == 0 and self._is_due(t_s):
            yield from self._take(bisect_right(self._instants_s, t_s - LAG_S))

    def close(self) -> Iterator[Intervals]:
        """All other intervals; none if not all bodies were placed: then nothing moved."""
        if self._unplaced == 0:
            yield from self._take(len(self._instants_s))

    def _is_due(self, now_s: float) -> bool:
        at_once = self._at_once
        return len(self._instants_s) > at_once and self._instants_s[at_once - 1] <= now_s - LAG_S

    def _take(self, count: int) -> Iterator[Intervals]:
        """The next intervals, so many."""
        robots = len(self._samples)
        while count > 0:
            many = min(count, self._at_once)
            instants_s = np.unique(self._instants_s[:many])
            del self._instants_s[:many]
            count -= many
            places_m = self._places_m(instants_s)
            before_m = places_m[:1] if self._ends_m is None else self._ends_m[np.newaxis]
            starts_m = np.concatenate((before_m, places_m[:-1]))
            self._ends_m, self._ended_s = places_m[-1], float(instants_s[-1])
            clear_m = clearance(self._ground, starts_m.reshape(-1, 2), places_m.reshape(-1, 2))
            yield Intervals(instants_s.tolist(), starts_m, places_m, clear_m.reshape(-1, robots))

    def _places_m(self, instants_s: Floats) -> Floats:
        """Where all bodies were at these times; samples from before the last of them are dropped."""
        places_m = np.empty((len(instants_s), len(self._samples), 2))
        last_s = instants_s[-1]
        for row, samples in enumerate(self._samples):
            if len(samples) == 1:
                places_m[:, row] = samples[0][1:]  # as most bodies of a large fleet: it stands
                continue
            later = bisect_right(samples, last_s, key=itemgetter(0))
            sampled = np.array(samples[: later + 1])  # those of the next `LAG_S` are of no use here
            places_m[:, row, 0] = np.interp(instants_s, sampled[:, 0], sampled[:, 1])
            places_m[:, row, 1] = np.interp(instants_s, sampled[:, 0], sampled[:, 2])
            del samples[: max(later - 1, 0)]
        return places_m
