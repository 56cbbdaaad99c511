"""The guided search of one seed: its own run, and futures from instants at which a view begins. Shell.

Rule 1: the seed's own run is played first, to its end. Then it is played again up to its first instants.
        There the process forks, the fork plays a future to its end, and only then the run goes on. A future
        forks in the same way at the first instants that it comes to. So a search goes depth first, and needs
        no other process.
Rule 2: an instant is the start of a run, or a new epoch of the fence. There the robots agree anew on who may
        move, and messages from before are still on their way.
Rule 3: which futures are played depends on the seed and on the cells known before, on nothing else. So a
        search is the same every time.
Rule 4: a future that surprises is played again from the start, without forks; that outcome counts.
Rule 5: a run is judged as it goes, and ended once something is broken.
"""

import resource
import signal
import time
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

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
from clew.guided.corpus import Corpus
from clew.guided.forks import in_a_fork
from clew.guided.look import in_focus, look
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.draws import Draws
from clew.swarm.futures import Branches, branch_at, branched, said
from protocol.exit_codes import ExitCode
from protocol.timeline import FenceChanged, PromiseBroken
from world.bodies.arena import ODOMETRY_TICKS


class Limits(Struct, frozen=True, kw_only=True):
    """How much a search may play."""

    roots_max: int = 8
    """Futures of the seed's own run, from its first instants."""
    below_max: int = 7
    """Futures of each of them, and theirs."""


class Instant(NamedTuple):
    """Rule 2."""

    tick: int
    t_s: float


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
        run.branch_out(own.instants[: limits.roots_max])
        futures, visits = run.futures, visits + run.visits
        if run.surprise is not None:
            outcome = _again(replace(episode, branches=run.surprise))
    new = sum(cell not in known for cell in visits)
    spent = {"cpu_s": _spent_s() - before, "wall_s": time.monotonic() - started_wall_s}
    return Found(outcome=replace(outcome, futures=futures, cells=new, **spent), visits=dict(visits))


def _again(future: Episode) -> Outcome:
    """Rule 4. A future that does not surprise again is a bug of ours: it is not decided by its seed."""
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
        self._heard = 0
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
                if self._rehearsal.world.judgement is None:  # rule 5
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
            for future in range(1, self._limits.roots_max // len(instants) + 1):
                self._left = 1 + self._limits.below_max
                self._fork(instant.t_s, future)
                if self.surprise is not None:
                    return

    def _go_on(self) -> None:
        """Play to the end, or until a future surprises."""
        for tick, now_s in self._ticks:
            if tick % ODOMETRY_TICKS and tick > 1:
                continue  # most of what cells tell changes with odometry only
            new = [entry.record for _, entry in self._rehearsal.entries[self._heard :]]
            self._heard += len(new)
            if any(isinstance(each, PromiseBroken) for each in new):  # rule 5
                return
            reached = look(self._rehearsal)
            self.visits.update(reached - self._reached)
            self._reached |= reached
            if tick == 1 or any(isinstance(each, FenceChanged) and each.turn == 0 for each in new):
                self._pass(Instant(tick, now_s), reached)
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

    def _pass(self, instant: Instant, reached: set[Cell]) -> None:
        """Play futures from this instant, as many as it is worth and as are left."""
        self.instants.append(instant)
        for future in range(1, self._corpus.worth(reached) + 1):
            if self._left > 0 and self.surprise is None:
                self._fork(instant.t_s, future)

    def _fork(self, now_s: float, future: int) -> None:
        """Rule 1."""
        draws = Draws(self._episode.seed, f"guided/{said(self._branches)}/{now_s}/{future}")
        branch = branch_at(now_s, draws.pick(in_focus(self._rehearsal)), future)
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
        self._left -= 1
        self.futures, self.visits, self._heard = 1, Counter(), len(self._rehearsal.entries)
        if not self._ends_well():
            self.surprise = said(branches)
        return msgspec.msgpack.encode(Played(self.surprise, self.futures, dict(self.visits)))


def _spent_s() -> float:
    """CPU time of this process and of all that it has waited for."""
    ours, theirs = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return ours.ru_utime + ours.ru_stime + theirs.ru_utime + theirs.ru_stime
