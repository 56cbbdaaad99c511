"""The judgement of a run from its timeline alone: S1 and S2 by the same rules as live, and all others.

Between two samples a body moved straight at constant speed. So the samples of all bodies divide the run into
intervals in which all bodies did; the monitor watches these intervals instead of ticks.
"""

from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np
from msgspec import Struct

from protocol.arrays import Floats
from protocol.errors import sentence_of
from protocol.timeline import Entry, PromiseBroken
from world.geometry.clearance import clearance
from world.geometry.shapes import Ground
from world.judge.evidence import Evidence
from world.judge.invariants import ARRIVAL, INVARIANTS, judge_invariants
from world.judge.monitor import Least, Monitor
from world.judge.motion import Tolerance
from world.judge.rule import Dated, Rule
from world.judge.truth.truth import Truth
from world.scenario.scenario import Scenario

MOVES_AT_ONCE = 1000  # moves judged against obstacles in one call: more need memory and save no time


class Breach(Struct, frozen=True, kw_only=True):
    """A broken promise and its time."""

    t_s: float
    broken: PromiseBroken


class Judgement(Struct, frozen=True, kw_only=True):
    """The results of judging a timeline."""

    least_clearance: Least
    least_separation: Least
    least_moving_clearance: Least
    path_m: float
    """Metres driven by all robots."""
    breaches: tuple[Breach, ...]
    failure: str | None = None
    """Why the judge failed, which should never happen: then nothing is proved."""

    @property
    def untrue(self) -> frozenset[int]:
        """The robots that recorded an arrival which their poses do not show."""
        return untrue_in(self.breaches)

    @property
    def violations(self) -> dict[str, int]:
        """How often each promise was broken."""
        counts = Counter(breach.broken.invariant for breach in self.breaches)
        return {invariant: counts[invariant] for invariant in INVARIANTS}


def untrue_in(breaches: Iterable[Breach]) -> frozenset[int]:
    """The robots of broken arrivals."""
    return frozenset(each.broken.robot for each in breaches if each.broken.invariant in ARRIVAL)


class Judge:
    """Judges one run as its entries come; the same object judges live runs, rehearsals and logs."""

    def __init__(self, scenario: Scenario) -> None:
        self._whole = _Whole(scenario)
        self._rules: tuple[Rule, ...] = (self._whole, Truth(scenario))
        self._breaches: list[Breach] = []
        self._failure: str | None = None

    def hear(self, source: str, entry: Entry) -> list[Breach]:
        """Process the next entry of the timeline; returns the violations that are certain now."""
        if self._failure is not None:
            return []
        return self._note(each for rule in self._rules for each in rule.hear(source, entry))

    def close(self) -> Judgement:
        """The judgement of the run: no entry follows."""
        if self._failure is None:
            self._note(each for rule in self._rules for each in rule.close())
        monitor = self._whole.monitor
        return Judgement(
            least_clearance=monitor.least_clearance,
            least_separation=monitor.least_separation,
            least_moving_clearance=monitor.least_moving_clearance,
            path_m=self._whole.path_m,
            breaches=tuple(sorted(self._breaches, key=lambda breach: breach.t_s)),
            failure=self._failure,
        )

    def _note(self, found: Iterable[Dated]) -> list[Breach]:
        new: list[Breach] = []
        try:
            new.extend(Breach(t_s=t_s, broken=broken) for t_s, broken in found)
        except Exception as error:  # a run that cannot be judged has failed, and says why
            self._failure = sentence_of(error)
        self._breaches += new
        return new


def judge(scenario: Scenario, lines: Iterable[tuple[str, Entry]]) -> Judgement:
    """Judge a timeline, given as sources and their entries in the recorder's order."""
    judge = Judge(scenario)
    for source, entry in lines:
        judge.hear(source, entry)
    return judge.close()


class _Whole:
    """All rules as they were: at the end."""

    def __init__(self, scenario: Scenario) -> None:
        self.monitor = Monitor.of(scenario)
        self.path_m = 0.0
        self._scenario = scenario
        self._evidence = Evidence()

    def hear(self, source: str, entry: Entry) -> Iterable[Dated]:
        """Process an entry."""
        self._evidence.hear(source, entry)
        return ()

    def close(self) -> Iterable[Dated]:
        """Every violation."""
        scenario, monitor = self._scenario, self.monitor
        for t_s, starts_m, ends_m, clear_m in intervals(
            self._evidence, monitor.ground, scenario.fleet.robots
        ):
            for each in monitor.watch(starts_m, ends_m, t_s=t_s, clear_m=clear_m):
                yield t_s, each
            self.path_m += float(np.hypot(*(ends_m - starts_m).T).sum())
        tolerance = Tolerance(
            mu0_m=scenario.law.mu0_m,
            heading_error_rad=scenario.drive.heading_error_rad,
            speed_mps_max=scenario.drive.speed_mps_max,
        )
        followers_sense = scenario.law.law.promises_clearance
        yield from judge_invariants(self._evidence, tolerance, followers_sense=followers_sense)


def intervals(
    evidence: Evidence, ground: Ground, robots: int
) -> Iterator[tuple[float, Floats, Floats, Floats]]:
    """Simultaneous straight moves of all bodies: end time, starts, ends, and clearance from obstacles.

    The first interval has no motion: it is the initial placement.
    """
    samples = [evidence.poses[robot] for robot in range(1, robots + 1)]
    if not all(samples):
        return  # the run ended before the bodies were placed: nothing moved
    instants_s = np.unique([t_s for each in samples for t_s, _ in each])
    places_m = np.empty((len(instants_s), robots, 2))
    for row, each in enumerate(samples):
        sampled_s = [t_s for t_s, _ in each]
        places_m[:, row, 0] = np.interp(instants_s, sampled_s, [pose.x_m for _, pose in each])
        places_m[:, row, 1] = np.interp(instants_s, sampled_s, [pose.y_m for _, pose in each])
    starts_m = np.concatenate((places_m[:1], places_m[:-1]))
    at_once = max(MOVES_AT_ONCE // robots, 1)
    for first in range(0, len(instants_s), at_once):
        chunk = slice(first, first + at_once)
        moves_m = starts_m[chunk].reshape(-1, 2), places_m[chunk].reshape(-1, 2)
        clear_m = clearance(ground, *moves_m).reshape(-1, robots)
        yield from zip(instants_s[chunk].tolist(), starts_m[chunk], places_m[chunk], clear_m, strict=True)
