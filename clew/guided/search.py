"""The guided search of one seed: its own run, and futures from where that has reached something rare. Shell.

Rule 1: the seed's own run is played first, to its end. Then it is played again up to its rarest instants.
        There the process forks, the fork plays a future to its end, and only then the run goes on. A future
        forks in the same way at the first rare instants that it comes to. So a search goes depth first, and
        needs no other process.
Rule 2: which futures are played depends on the seed and on the cells known before, on nothing else. So a
        search is the same every time.
Rule 3: a future that surprises is played again from the start, without forks; that outcome counts.
Rule 4: a run is judged as it goes, and ended once something is broken.
"""

import math
import resource
import signal
import time
from collections import Counter
from collections.abc import Sequence

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.episode import (
    CRASHED,
    OUT_OF_TIME,
    Episode,
    Outcome,
    OutOfTimeError,
    Surprise,
    failed,
    last_line,
    outcome_of,
    play,
    set_stage,
    wall_clock_limit,
)
from clew.guided.cells import Cell
from clew.guided.corpus import Corpus, Instant
from clew.guided.forks import in_a_fork
from clew.guided.look import in_focus, look
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.draws import Draws
from clew.swarm.futures import Branch, Branches, branch_at, branched, said
from protocol.exit_codes import ExitCode
from protocol.fence import May
from protocol.timeline import PromiseBroken
from world.bodies.arena import ODOMETRY_TICKS


class Limits(Struct, frozen=True, kw_only=True):
    """How much a search may play."""

    instants_max: int = 4
    """Instants of the seed's own run from which futures are played."""
    futures_each: int = 1
    """Futures from each of them."""
    below_max: int = 3
    """Futures of one future: with all, a search takes some three times the CPU time of the seed's own run."""
    depth_max: int = 4
    apart_s: float = 0.3
    """Time between two instants from which futures are played: a report, its answer and a turn."""


class Played(Struct, frozen=True):
    """What has become of a future and of its own futures."""

    surprise: str | None
    """The branches of the one that surprises; None: none does."""
    futures: int
    visits: dict[Cell, int]
    """In how many runs each cell was reached for the first time."""


class Found(Struct, frozen=True, kw_only=True):
    """What a search has found."""

    outcome: Outcome
    """Of the first surprise, or of the seed's own faults."""
    visits: dict[Cell, int]
    """In how many of its runs each cell was reached."""


PLAYED = msgspec.msgpack.Decoder(Played)


def search(episode: Episode, known: Corpus, limits: Limits) -> Found:
    """Search the futures of one seed."""
    started_wall_s, before = time.monotonic(), _spent_s()
    own, corpus, futures = _Run(episode, Corpus(known.visits), limits), Corpus(known.visits), 0
    outcome, visits = own.play(), Counter(own.visits)
    corpus.add(visits)
    if outcome.surprise is Surprise.NONE:
        run = _Run(episode, corpus, limits)
        run.branch_out(known.rarest(own.instants, limits.instants_max, limits.apart_s))
        futures, visits = run.futures, visits + run.visits
        if run.surprise is not None:
            outcome = _again(replace(episode, branches=run.surprise))
    new = sum(cell not in known for cell in visits)
    spent = {"cpu_s": _spent_s() - before, "wall_s": time.monotonic() - started_wall_s}
    return Found(outcome=replace(outcome, futures=futures, cells=new, **spent), visits=dict(visits))


def _again(future: Episode) -> Outcome:
    """Rule 3. A future that does not surprise again is a bug of ours: it is not decided by its seed."""
    outcome = play(future)
    if outcome.surprise is not Surprise.NONE:
        return outcome
    return failed(future, CRASHED, f"future {future.branches} surprised in a fork only", 0.0)


def lost(episode: Episode) -> Found:
    """What came of a search whose process has died."""
    return Found(outcome=failed(episode, CRASHED, "its process died", 0.0), visits={})


class _Run:
    """A run of a search: first the seed's own; in each fork it turns into a future."""

    def __init__(self, episode: Episode, corpus: Corpus, limits: Limits) -> None:
        self._episode, self._limits = replace(episode, branches=""), limits
        self._stage = set_stage(self._episode)
        assert self._stage.swarm is not None, "only a swarm has futures"
        self._swarm = self._stage.swarm
        self._rehearsal = Rehearsal(self._stage.scenario, episode.seed, self._stage.plan)
        self._ticks = enumerate(self._rehearsal.ticks(), start=1)
        self._corpus = corpus
        self._branches: Branches = ()
        self._left = 0
        """How many futures it may still have."""
        self._reached: set[Cell] = set()
        self._forked_s = -math.inf
        self._looked_at = 0
        """How many entries have been looked at."""
        self.instants: list[Instant] = []
        self.futures = 0
        self.visits: Counter[Cell] = Counter()
        self.surprise: str | None = None
        """The branches of the first future that surprises."""

    def play(self) -> Outcome:
        """Play the seed's own run."""
        try:
            with wall_clock_limit(self._episode.wall_s_max):
                self._go_on()
                if self._rehearsal.world.judgement is None:  # rule 4
                    self._rehearsal.stop(ExitCode.TERMINATED)
                    for _ in self._ticks:
                        pass
            return outcome_of(self._episode, self._stage, self._rehearsal, wall_s=0.0)
        except OutOfTimeError:
            return failed(self._episode, OUT_OF_TIME, "the wall-clock limit struck", 0.0, stage=self._stage)
        except Exception as error:
            return failed(self._episode, CRASHED, last_line(error), 0.0, stage=self._stage)

    def branch_out(self, instants: Sequence[Instant]) -> None:
        """Play the seed's own run again, with futures from these instants, in order."""
        for instant in instants:
            while next(self._ticks)[0] < instant.tick:
                pass
            draws = Draws(self._episode.seed, f"guided/{instant.t_s}")
            for future in range(1, self._limits.futures_each + 1):
                self._left = 1 + self._limits.below_max
                self._fork(branch_at(instant.t_s, draws.pick(in_focus(self._rehearsal)), future))
                if self.surprise is not None:
                    return

    def _go_on(self) -> None:
        """Play to the end, or until a future surprises."""
        for tick, now_s in self._ticks:
            if tick % ODOMETRY_TICKS:
                continue  # most of what cells tell changes with odometry only
            if self._breaks():
                return
            self._pass(tick, now_s)
            if self.surprise is not None:
                return

    def _ends_well(self) -> bool:
        """Play a future to its end; whether nothing surprises that was not there before."""
        try:
            with wall_clock_limit(self._episode.wall_s_max):
                self._go_on()
        except (OutOfTimeError, Exception):
            return False
        judgement = self._rehearsal.world.judgement
        if self.surprise is not None:
            return True  # of a future of this one
        return judgement is not None and not judgement.breaches

    def _breaks(self) -> bool:
        """Rule 4: the world's judge records what it finds."""
        new, self._looked_at = self._rehearsal.entries[self._looked_at :], len(self._rehearsal.entries)
        return any(isinstance(entry.record, PromiseBroken) for _, entry in new)

    def _pass(self, tick: int, now_s: float) -> None:
        """Look at what is new, and play futures from here, as many as the instant is worth."""
        fresh = frozenset(look(self._rehearsal) - self._reached)
        if not fresh:
            return
        self._reached |= fresh
        self.visits.update(fresh)
        view_changes = self._rehearsal.world.arena.fence.may is not May.ALL
        self.instants.append(Instant(tick, now_s, fresh, view_changes))
        if self._left == 0 or now_s - self._forked_s < self._limits.apart_s:
            return
        self._forked_s = now_s
        draws = Draws(self._episode.seed, f"guided/{said(self._branches)}/{now_s}")
        worth = self._corpus.worth(fresh, draws)
        self._corpus.add(fresh)
        for future in range(1, worth + 1):
            if self._left > 0 and self.surprise is None:
                self._fork(branch_at(now_s, draws.pick(in_focus(self._rehearsal)), future))

    def _fork(self, branch: Branch) -> None:
        """Rule 1."""
        branches = (*self._branches, branch)
        left_s, _ = signal.setitimer(signal.ITIMER_REAL, 0.0)  # a fork has a wall-clock limit of its own
        told = in_a_fork(lambda: self._play_future(branches))
        signal.setitimer(signal.ITIMER_REAL, left_s)
        played = Played(said(branches), 1, {}) if told is None else PLAYED.decode(told)
        self._left -= played.futures
        self.futures += played.futures
        self.visits.update(played.visits)
        self._corpus.merge(played.visits)
        self.surprise = played.surprise

    def _play_future(self, branches: Branches) -> bytes:
        """Turn into the future with these branches, and play it; in a fork."""
        self._branches, self._swarm = branches, branched(self._swarm, branches)
        self._rehearsal.turn_to(self._swarm.plan)
        self._rehearsal.world.limit(float(self._swarm.world["time"]["time_s_max"]))
        is_deepest = len(branches) >= self._limits.depth_max
        self._left = 0 if is_deepest else self._left - 1
        self.futures, self.visits = 1, Counter()
        if not self._ends_well():
            self.surprise = said(branches)
        return msgspec.msgpack.encode(Played(self.surprise, self.futures, dict(self.visits)))


def _spent_s() -> float:
    """CPU time of this process and of all that it has waited for."""
    ours, theirs = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return ours.ru_utime + ours.ru_stime + theirs.ru_utime + theirs.ru_stime
