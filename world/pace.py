"""Schedules ticks against the wall clock. Pure: the time is an argument.

Rule 1: no tick is skipped; a late world runs slower. It catches up by at most one odometry period, since
        robots could not answer a longer burst in time.
Rule 2: no tick is due while the world waits for robots that are late (`world.answers`). So the speed that
        was asked for is an upper bound. Odometry is sent again every `REPEAT_S`: it may be lost.
Rule 3: in lock-step the world ticks at once, unless answers of robots are missing. It waits `PATIENCE_S` for
        them at most. Odometry is state, so it is sent again to such a robot: a message may be lost.
Rule 4: a held run ticks in lock-step as far as it was asked to go, so that it never runs ahead of a test that
        has no processor time. It is released when nobody has asked for `HELD_S_MAX`: the test may be dead.
Rule 5: when the run is over robots do not answer, and the world ticks in real time.
Rule 6: a tick is late by the time from when it was due, at the speed that was asked for, until it is made.
"""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.core import World
from world.judge.verdict import Late

PATIENCE_S = 1.0  # docs/run.md
GLANCE_S = 0.1  # wall: the longest delay in noticing a signal or a deadline
REMIND_S = 0.05  # wall: far longer than an answer takes if no message is lost
HELD_S_MAX = 60.0  # wall: a test on a loaded machine was seen to pause for some seconds
HELD_GLANCE_S = 0.01  # wall: a held run is asked every 0.02 s
LATE_MS_MAX = 60_000  # bounds what is kept; no tick that anybody waits for is later
REPEAT_S = 0.5  # wall: a machine that is late already is not to be given more work
REPEAT_S_PER_ROBOT = 0.004  # so long do many robots take to answer on such a machine


def repeat_s(robots: int) -> float:
    """After how long odometry is sent again to those that are late of so many robots [wall s]."""
    return max(REPEAT_S, REPEAT_S_PER_ROBOT * robots)


@dataclass(slots=True)
class Pace:
    """The pace of one run; `speed` None means lock-step."""

    speed: float | None
    is_excused: Callable[[int], bool] = lambda _: False
    """Whether a fault holds a robot up: no tick waits for that."""
    held_at_s: float = math.inf
    """The simulated time beyond which a held run does not go (rule 4)."""
    _asked_wall_s: float | None = None
    _due_wall_s: float | None = None
    _told_wall_s: float = 0.0
    _ran_s: float = 0.0
    """Simulated time for which the clock has run."""
    _took_s: float = 0.0
    """How long that took [wall s]."""
    _ticked_wall_s: float | None = None
    _late_ms: Counter[int] = field(default_factory=Counter)
    """How many ticks were so late (rule 6)."""

    def wait_s(self, world: World, *, wall_s: float) -> float:
        """How long to wait for arrivals [wall s]; 0 when a tick is due."""
        if not world.started:
            return GLANCE_S
        if self._due_wall_s is None:
            self._due_wall_s = wall_s + (PATIENCE_S if self._in_lock_step(world) else 0.0)
        left_s = max(self._due_wall_s - wall_s, 0.0)
        if self._in_lock_step(world):
            if self._holds(world, wall_s):
                return HELD_GLANCE_S
            return min(left_s, REMIND_S) if world.awaited else 0.0
        if left_s > 0.0:
            return min(left_s, GLANCE_S)
        return GLANCE_S if any(True for _ in world.held_up(self.is_excused, wall_s=wall_s)) else 0.0

    def go(self, until_s: float, *, wall_s: float) -> None:
        """A held run may go on until this simulated time."""
        self.held_at_s, self._asked_wall_s = until_s, wall_s

    def _holds(self, world: World, wall_s: float) -> bool:
        """Whether the run waits to be asked to go on (rule 4)."""
        if world.now_s < self.held_at_s:
            return False
        if self._asked_wall_s is None:
            self._asked_wall_s = wall_s
        return wall_s - self._asked_wall_s <= HELD_S_MAX

    def take_reminder(self, world: World, *, wall_s: float) -> set[int]:
        """The robots to which odometry is to be sent again; naming them restarts the period."""
        period_s = REMIND_S if self._in_lock_step(world) else repeat_s(world.robots_in_all)
        if wall_s - self._told_wall_s < period_s or world.ending is not None:
            return set()
        in_lock_step = self._in_lock_step(world)
        late = world.awaited if in_lock_step else set(world.held_up(self.is_excused, wall_s=wall_s))
        if late:
            self._told_wall_s = wall_s
        return late

    def ticked(self, world: World, *, wall_s: float) -> None:
        """Note that a tick was made."""
        assert self._due_wall_s is not None, "ticked before it was due"
        self._told_wall_s = wall_s
        if self._in_lock_step(world):
            self._due_wall_s = wall_s + PATIENCE_S
            return
        period_s, late_s = TICK_S / (self.speed or 1.0), wall_s - self._due_wall_s
        self._due_wall_s = max(self._due_wall_s + period_s, wall_s - ODOMETRY_TICKS * period_s)
        if world.ending is None and self._ticked_wall_s is not None:
            self._ran_s += TICK_S
            self._took_s += wall_s - self._ticked_wall_s
            self._late_ms[min(round(1000.0 * late_s), LATE_MS_MAX)] += 1
        self._ticked_wall_s = wall_s

    def resume(self) -> None:
        """The world's process was stopped on purpose: that time says nothing about the machine."""
        self._ticked_wall_s = None

    @property
    def speed_reached(self) -> float | None:
        """Simulated seconds per wall-clock second so far; None: too short to say, or in lock-step."""
        return self._ran_s / self._took_s if self._took_s >= PATIENCE_S else None

    @property
    def late(self) -> Late | None:
        """How late ticks were (rule 6); None: no tick had a time."""
        return Late(p50_s=self._late_s(50), p99_s=self._late_s(99)) if self._late_ms else None

    def _late_s(self, percent: int) -> float:
        """A percentile, by nearest rank."""
        rank = max(-(-percent * self._late_ms.total() // 100), 1)
        for late_ms, count in sorted(self._late_ms.items()):
            rank -= count
            if rank <= 0:
                return late_ms / 1000.0
        return 0.0

    def _in_lock_step(self, world: World) -> bool:
        return self.speed is None and world.ending is None
