"""Explores all schedules with at most so many faults. Pure: the caller says when time is up.

Rule 1: states are expanded in the order of their ranks, each once, however many schedules lead to it.
Rule 2: with a state comes the number of schedules that reach it, by their number of faults. So what was
        covered is counted, though most of it was never run.
Rule 3: the faults of a state are tried if some schedule reaches it with fewer faults than may strike.
Rule 4: where no fault may strike any more, one state leads to one other. So several steps are taken at once,
        and the states between are judged but not remembered (`Explorable.hurry`).
Rule 5: the first breach ends the exploration. With ever more faults (`deepen`) it has as few as possible.
"""

import heapq
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from typing import Generic, NamedTuple

from msgspec import Struct

from clew.explore.explorable import Breach, Explorable, Fault, Rank, State

STATES_PER_LOOK = 256  # states between two questions whether time is up


class Ended(StrEnum):
    """Why an exploration ended."""

    COMPLETE = "complete"
    BREACH = "breach"
    TIME = "time"


class Strike(NamedTuple):
    """A fault that strikes in the state of this rank."""

    rank: Rank
    fault: Fault


class _Chain(NamedTuple):
    """The faults of a schedule, the last one first; schedules share their beginnings."""

    last: Strike
    before: "_Chain | None"


class Broken(Struct, frozen=True, kw_only=True):
    """A broken promise, and a schedule that breaks it."""

    promise: str
    why: str
    strikes: tuple[Strike, ...]
    """Its faults, the first one first."""


class Explored(Struct, frozen=True, kw_only=True):
    """What an exploration has covered and found."""

    faults: int
    """How many faults a schedule has at most."""
    ended: Ended
    states: int
    transitions: int
    depth: int
    """The steps of the longest schedule."""
    schedules: tuple[int, ...]
    """How many schedules reach their end, by their number of faults."""
    broken: Broken | None = None


@dataclass(slots=True)
class _Reached:
    """What is known of a state that has not been expanded yet."""

    ways: list[int]
    strikes: _Chain | None
    depth: int

    @property
    def faults(self) -> int:
        """The least number of faults by which it is reached."""
        return next(faults for faults, ways in enumerate(self.ways) if ways)

    def also(self, other: "_Reached") -> None:
        """Take in that it is reached in other ways, too."""
        if other.faults < self.faults:
            self.strikes = other.strikes
        self.ways = [sum(both) for both in zip(self.ways, other.ways, strict=True)]
        self.depth = max(self.depth, other.depth)


class Exploration(Generic[State]):
    """One exploration of a system."""

    def __init__(self, system: Explorable[State], faults_max: int) -> None:
        self._system = system
        self._faults_max = faults_max
        self._levels: dict[Rank, dict[State, _Reached]] = {}
        self._ranks: list[Rank] = []
        self._states = self._transitions = self._depth = 0
        self._schedules = [0] * (faults_max + 1)

    def run(self, may_go_on: Callable[[], bool]) -> Explored:
        """Explore until all is covered, a promise breaks, or time is up."""
        self._add(self._system.start(), _Reached([1] + [0] * self._faults_max, None, 0))
        began = 0
        while self._ranks:
            if self._ranks[0][0] > began:
                began = self._ranks[0][0]
                self._system.keep_only(chain.from_iterable(self._levels.values()))
            level = self._levels.pop(heapq.heappop(self._ranks))
            while level:
                state, reached = level.popitem()
                if self._states % STATES_PER_LOOK == 0 and not may_go_on():
                    return self._result(Ended.TIME)
                if (broken := self._expand(state, reached)) is not None:
                    return self._result(Ended.BREACH, broken)
        return self._result(Ended.COMPLETE)

    def _expand(self, state: State, reached: _Reached) -> Broken | None:
        """Take every step from a state (rule 1)."""
        system, ways = self._system, reached.ways
        self._states += 1
        self._depth = max(self._depth, reached.depth)
        strikes = reached.strikes
        strikes_more = reached.faults < self._faults_max and system.is_open(state)
        try:
            usual = system.follow(state) if strikes_more else system.hurry(state)
            if usual is None:
                self._schedules = [sum(both) for both in zip(self._schedules, ways, strict=True)]
            else:
                self._add(usual, _Reached(list(ways), strikes, reached.depth + 1))
            if not strikes_more:
                return None
            more, rank = [0, *ways[:-1]], system.rank(state)
            for fault in system.faults(state):
                strikes = _Chain(Strike(rank, fault), reached.strikes)
                after = system.strike(state, fault)
                self._add(after, _Reached(list(more), strikes, reached.depth + 1))
        except Breach as breach:
            self._transitions += 1
            return Broken(promise=breach.promise, why=breach.why, strikes=_in_order(strikes))
        return None

    def _add(self, state: State, reached: _Reached) -> None:
        self._transitions += reached.depth > 0
        rank = self._system.rank(state)
        level = self._levels.get(rank)
        if level is None:
            level = self._levels[rank] = {}
            heapq.heappush(self._ranks, rank)
        known = level.setdefault(state, reached)
        if known is not reached:
            known.also(reached)

    def _result(self, ended: Ended, broken: Broken | None = None) -> Explored:
        return Explored(
            faults=self._faults_max,
            ended=ended,
            states=self._states,
            transitions=self._transitions,
            depth=self._depth,
            schedules=tuple(self._schedules),
            broken=broken,
        )


def at_once(breach: Breach) -> Explored:
    """The result where a promise breaks before there is anything to explore."""
    broken = Broken(promise=breach.promise, why=breach.why, strikes=())
    return Explored(
        faults=0, ended=Ended.BREACH, states=0, transitions=0, depth=0, schedules=(), broken=broken
    )


def _in_order(strikes: _Chain | None) -> tuple[Strike, ...]:
    listed: list[Strike] = []
    while strikes is not None:
        listed.append(strikes.last)
        strikes = strikes.before
    return tuple(listed[::-1])


def deepen(system: Explorable[State], faults_max: int, may_go_on: Callable[[], bool]) -> Iterator[Explored]:
    """Explore without faults, then with one at most, and so on; stops at a breach or when time is up."""
    for faults in range(faults_max + 1):
        explored = Exploration(system, faults).run(may_go_on)
        yield explored
        if explored.ended is not Ended.COMPLETE:
            return


def retell(system: Explorable[State], strikes: Sequence[Strike]) -> Iterator[tuple[Rank, str, Fault | None]]:
    """Every step of a schedule that is given by its faults, until its end or its breach; for people.

    Yields the rank, the usual step, and the fault that strikes instead.
    """
    left, state = list(strikes), system.start()
    while True:
        rank = system.rank(state)
        fault = left.pop(0).fault if left and left[0].rank == rank else None
        yield rank, system.say(state), fault
        after = system.follow(state) if fault is None else system.strike(state, fault)
        if after is None:
            return
        state = after
