"""One process of a search: plays a rehearsal, and holds it where it reaches something new. A shell.

Rule 1: at a new cell the process forks. The child plays on; the parent keeps the run as it is at that
        instant, and waits to be told which future to play from there, in another child each time.
Rule 2: of all processes of a search at most one plays. All others wait for the search, and end with it.
Rule 3: a held run that is given up says so, so that its slot can be used again. It ends once its children
        have. All are given up when the search closes its ends of the pipes.
"""

import math
import os
import signal
from multiprocessing.connection import Connection
from typing import NoReturn

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.episode import (
    CRASHED,
    OUT_OF_TIME,
    Episode,
    Outcome,
    OutOfTimeError,
    Stage,
    failed,
    last_line,
    outcome_of,
)
from clew.guided.cells import Cell
from clew.guided.look import look
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.futures import Branches, branch_at, branched, branches_until_s, said
from protocol.exit_codes import ExitCode
from protocol.timeline import PromiseBroken, RobotFailed
from world.bodies.arena import ODOMETRY_TICKS


class Limits(Struct, frozen=True, kw_only=True):
    """How much a search may play."""

    slots: int = 16
    """Runs that are held at a time; each is a process of 10 to 20 MB."""
    depth_max: int = 4
    futures_max: int = 3
    """Futures from one held run."""
    horizon_s: float = 5.0
    """How long a future is played: its faults begin within 2 s, and breaches come within some 3 s of one."""
    sim_s_max: float = 120.0
    """Simulated time of all futures of a seed: three times an episode's own."""
    apart_s: float = 1.0
    """Time between two runs that are held: a search reaches all of an episode with its slots."""
    held_max: int = 3
    """Runs that are held of one future."""


class GoOn(Struct, frozen=True):
    """The order to play a future from a held run."""

    future: int
    """Its number; 0: play none, and give up."""
    free: tuple[int, ...]
    """Slots for further held runs."""
    known: frozenset[Cell]


class HeldAt(Struct, frozen=True, tag=True):
    """A run is held in this slot."""

    slot: int
    from_s: float
    cells: frozenset[Cell]
    depth: int


class Over(Struct, frozen=True, tag=True):
    """A run is over."""

    branches: str
    reached: frozenset[Cell]
    outcome: Outcome
    sim_s: float
    """Simulated time from its last branch on."""


class GivenUp(Struct, frozen=True, tag=True):
    """The run in this slot is held no more: another one can take the slot."""

    slot: int


Report = HeldAt | Over | GivenUp
ORDERS: msgspec.msgpack.Decoder[GoOn] = msgspec.msgpack.Decoder(GoOn)
REPORTS: msgspec.msgpack.Decoder[Report] = msgspec.msgpack.Decoder(HeldAt | Over | GivenUp)


class Runner:
    """A run and its part in the search."""

    def __init__(
        self, episode: Episode, stage: Stage, limits: Limits, slots: list[Connection], reports: Connection
    ) -> None:
        assert stage.swarm is not None, "only a swarm has futures"
        self._episode, self._stage, self._limits = episode, stage, limits
        self._slots, self._reports = slots, reports
        self._swarm = stage.swarm
        self._rehearsal = Rehearsal(stage.scenario, episode.seed, stage.plan)
        self._branches: Branches = ()
        self._known: frozenset[Cell] = frozenset()
        self._free: list[int] = []
        self._reached: set[Cell] = set()
        self._began_s = self._held_s = 0.0
        self._until_s = math.inf
        self._entries = 0
        self._stopped = False

    def play(self, order: GoOn) -> NoReturn:
        """Play the run to its end, and report it; never returns."""
        self._known, self._free = order.known, list(order.free)
        signal.signal(signal.SIGALRM, _strike)
        self._set_alarm()
        try:
            for tick, now_s in enumerate(self._rehearsal.ticks(), start=1):
                if not self._stopped:
                    self._pass(tick, now_s)
            stage = self._stage
            if self._branches:  # cut off: it has had no time to heal
                stage = Stage(stage.scenario, stage.plan)
            outcome = outcome_of(self._episode, stage, self._rehearsal, wall_s=0.0)
        except OutOfTimeError:
            outcome = failed(self._episode, OUT_OF_TIME, "the wall-clock limit struck", 0.0)
        except Exception as error:
            outcome = failed(self._episode, CRASHED, last_line(error), 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        sim_s = self._rehearsal.world.now_s - self._began_s
        self._report(Over(said(self._branches), frozenset(self._reached), outcome, sim_s))
        _end()

    def _pass(self, tick: int, now_s: float) -> None:
        """Look at the run after a tick; most of what cells tell changes with odometry only."""
        if tick % ODOMETRY_TICKS:
            return
        if self._is_decided(now_s):
            self._rehearsal.stop(ExitCode.TERMINATED)
            self._stopped = True
            return
        cells = look(self._rehearsal) - self._reached
        self._reached |= cells
        if (fresh := cells - self._known) and self._may_hold(now_s):
            self._hold(now_s, frozenset(fresh))

    def _is_decided(self, now_s: float) -> bool:
        """Whether a future need not be played any further."""
        if not self._branches:
            return False
        entries = self._rehearsal.entries
        new, self._entries = entries[self._entries :], len(entries)
        broken = any(isinstance(entry.record, PromiseBroken | RobotFailed) for _, entry in new)
        return broken or now_s >= self._until_s

    def _may_hold(self, now_s: float) -> bool:
        return (
            bool(self._free)
            and len(self._branches) < self._limits.depth_max
            and now_s - self._held_s >= self._limits.apart_s
            and now_s < branches_until_s(self._swarm)
        )

    def _hold(self, now_s: float, cells: frozenset[Cell]) -> None:
        """Rule 1. Returns in the children only."""
        self._held_s = now_s
        slot = self._free.pop(0)
        if os.fork() == 0:
            self._set_alarm()
            self._report(HeldAt(slot, now_s, cells, len(self._branches)))
            return
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        while (order := _ordered(self._slots[slot])) is not None:
            if os.fork() == 0:
                self._branch(now_s, order)
                return
        self._report(GivenUp(slot))
        _end()

    def _branch(self, now_s: float, order: GoOn) -> None:
        """Turn into the future that is ordered."""
        self._branches = (*self._branches, branch_at(now_s, order.future))
        self._swarm = branched(self._swarm, self._branches)
        self._rehearsal.turn_to(self._swarm.plan)
        self._episode = replace(self._episode, branches=said(self._branches))
        self._stage = Stage(self._stage.scenario, self._swarm.plan, self._swarm)
        self._known, self._free, self._reached = order.known, list(order.free), set()
        self._began_s, self._entries = now_s, len(self._rehearsal.entries)
        self._until_s = now_s + self._limits.horizon_s
        self._set_alarm()

    def _set_alarm(self) -> None:
        """A fork has no alarm."""
        signal.setitimer(signal.ITIMER_REAL, self._episode.wall_s_max)

    def _report(self, report: Report) -> None:
        try:
            self._reports.send_bytes(msgspec.msgpack.encode(report))
        except OSError:
            _end()  # the search is no more


def _ordered(slot: Connection) -> GoOn | None:
    """The next order; None if the run is given up. Children that have ended meanwhile are reaped."""
    try:
        order = ORDERS.decode(slot.recv_bytes())
    except (EOFError, OSError):
        return None
    if order.future == 0:
        return None
    try:
        while os.waitpid(-1, os.WNOHANG)[0] != 0:
            pass
    except ChildProcessError:
        pass
    return order


def _end() -> NoReturn:
    """Rule 3."""
    try:
        while True:
            os.waitpid(-1, 0)
    except ChildProcessError:
        os._exit(0)


def _strike(_number: int, _frame: object) -> None:
    raise OutOfTimeError
