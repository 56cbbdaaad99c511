"""The guided search of one seed: its own run, then futures from where something was new. A shell.

Rule 1: which future comes next depends on the seed and on the cells known before, on nothing else. So a
        search is the same every time.
Rule 2: a future that surprises is played again from the start, without forks; that outcome counts. One that
        was cut off early and does not surprise when played whole is no surprise.
Rule 3: a search leaves no process, whatever happens.
"""

import os
import resource
import signal
import time
from collections import Counter
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import assert_never

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.episode import CRASHED, Episode, Outcome, Surprise, failed, play, set_stage
from clew.guided.cells import Cell
from clew.guided.corpus import Choice, Corpus, Held
from clew.guided.runner import REPORTS, GivenUp, GoOn, HeldAt, Limits, Over, Report, Runner

ENDS_S = 5.0  # a process that only has to end is gone within milliseconds
LATE_S = 30.0  # after an episode's own limit: its process is no more


class Found(Struct, frozen=True, kw_only=True):
    """What a search has found."""

    outcome: Outcome
    """Of the first surprise, or of the seed's own faults."""
    visits: dict[Cell, int]
    """In how many of its runs each cell was reached."""


def search(episode: Episode, known: Corpus, limits: Limits) -> Found:
    """Search the futures of one seed."""
    started_wall_s, before = time.monotonic(), _spent_s()
    with _Tree(episode, limits) as tree:
        found = _Search(episode, known, limits, tree).run()
    spent = {"cpu_s": _spent_s() - before, "wall_s": time.monotonic() - started_wall_s}
    return replace(found, outcome=replace(found.outcome, **spent))


def lost(episode: Episode) -> Found:
    """What came of a search whose process has died."""
    return Found(outcome=failed(episode, CRASHED, "its process died", 0.0), visits={})


class _Search:
    """The order in which the futures of a seed are played."""

    def __init__(self, episode: Episode, known: Corpus, limits: Limits, tree: "_Tree") -> None:
        self._episode, self._limits, self._tree = episode, limits, tree
        self._corpus = Corpus(known.visits)
        self._before = len(known)
        self._visits: Counter[Cell] = Counter()
        self._choice = Choice(self._corpus, limits.futures_max)
        self._free = list(range(limits.slots))
        self._futures = 0
        self._own: Outcome | None = None
        self._sim_s = 0.0

    def run(self) -> Found:
        self._tree.begin(self._order(0))
        while True:
            over = self._until_over()
            if over is None:
                return self._found(lost(self._episode).outcome)
            if (outcome := self._surprise(over)) is not None:
                return self._found(outcome)
            held = self._choice.best() if self._sim_s < self._limits.sim_s_max else None
            if held is None:
                assert self._own is not None, "the first run is the seed's own"
                return self._found(self._own)
            self._make_room(held)
            held.played += 1
            self._futures += 1
            self._tree.go_on(held.slot, self._order(held.played))

    def _until_over(self) -> Over | None:
        """Take in what the run reports until it is over; None if its process has died."""
        while (report := self._tree.report(self._episode.wall_s_max + LATE_S)) is not None:
            match report:
                case GivenUp():
                    pass
                case HeldAt(slot, from_s, cells, depth):
                    self._free.remove(slot)
                    self._choice.held.append(Held(slot, from_s, cells, depth))
                case Over():
                    self._corpus.add(report.reached)
                    self._visits.update(report.reached)
                    return report
                case _:
                    assert_never(report)
        return None

    def _surprise(self, over: Over) -> Outcome | None:
        """The outcome of a run that surprises (rule 2)."""
        if self._own is None:
            self._own = over.outcome
        else:
            self._sim_s += over.sim_s
        if over.outcome.surprise is Surprise.NONE:
            return None
        if not over.branches:
            return over.outcome
        whole = play(replace(self._episode, branches=over.branches))
        return None if whole.surprise is Surprise.NONE else whole

    def _order(self, future: int) -> GoOn:
        free = self._free if future == 0 else self._free[: self._limits.held_max]
        return GoOn(future, tuple(free), frozenset(self._corpus.visits))

    def _make_room(self, wanted: Held) -> None:
        """Give up the held runs that are worth least, until a quarter of the slots is free."""
        held = self._choice.held
        while len(self._free) < self._limits.slots // 4:
            worst = self._choice.worst()
            if worst is None or worst is wanted:
                return
            held.remove(worst)
            self._tree.give_up(worst.slot)
            self._free.append(worst.slot)

    def _found(self, outcome: Outcome) -> Found:
        cells = len(self._corpus) - self._before
        return Found(outcome=replace(outcome, futures=self._futures, cells=cells), visits=dict(self._visits))


class _Tree:
    """The processes of a search, and the pipes to them."""

    def __init__(self, episode: Episode, limits: Limits) -> None:
        self._episode, self._limits = episode, limits
        self._root = 0
        self._ours: list[Connection] = []
        self._theirs: list[Connection] = []

    def __enter__(self) -> "_Tree":
        for _ in range(self._limits.slots):
            theirs, ours = Pipe(duplex=False)
            self._ours.append(ours)
            self._theirs.append(theirs)
        self._reports, self._to_us = Pipe(duplex=False)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        """Rule 3: all that are held see their pipe closed; if one still plays, it is ended."""
        for each in (*self._ours, *self._theirs, self._to_us):
            each.close()
        if kind is not None or not self._all_have_ended():
            with suppress(ProcessLookupError):
                os.killpg(self._root, signal.SIGKILL)
        os.waitpid(self._root, 0)
        self._reports.close()

    def _all_have_ended(self) -> bool:
        """Wait until no process has our pipe open; returns whether that came soon."""
        try:
            while self._reports.poll(ENDS_S):
                self._reports.recv_bytes()
        except EOFError:
            return True
        return False

    def begin(self, order: GoOn) -> None:
        """Begin with the seed's own run."""
        self._root = os.fork()
        if self._root == 0:
            self._play(order)
        with suppress(OSError):
            os.setpgid(self._root, self._root)  # whichever of the two is first

    def _play(self, order: GoOn) -> None:
        try:
            os.setpgid(0, 0)  # signals from the terminal reach only us
            for each in (*self._ours, self._reports):
                each.close()
            stage = set_stage(replace(self._episode, branches=""))
            Runner(self._episode, stage, self._limits, self._theirs, self._to_us).play(order)
        finally:
            os._exit(1)

    def go_on(self, slot: int, order: GoOn) -> None:
        """Play a future of the run held in this slot."""
        self._ours[slot].send_bytes(msgspec.msgpack.encode(order))

    def give_up(self, slot: int) -> None:
        """End the run held in this slot; the slot can be used again."""
        self.go_on(slot, GoOn(0, (), frozenset()))
        while (report := self.report(ENDS_S)) is not None and report != GivenUp(slot):
            pass

    def report(self, within_s: float) -> Report | None:
        """The next report; None if none comes."""
        if not self._reports.poll(within_s):
            return None
        return REPORTS.decode(self._reports.recv_bytes())


def _spent_s() -> float:
    """CPU time of this process and of all that it has waited for."""
    ours, theirs = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return ours.ru_utime + ours.ru_stime + theirs.ru_utime + theirs.ru_stime
