"""When to tick, against the wall clock. Pure: the time is an argument.

Rule 1: no tick is skipped; a world that is late runs slower. It makes up for at most one odometry period,
        since a longer burst would outrun the robots that answer it.
Rule 2: in lock-step it ticks at once, unless robots owe an answer, and waits for those `PATIENCE_S` at most.
        Odometry is state, so it may be told again to a robot that owes an answer: one may be lost.
Rule 3: when the run is over nobody answers, and real time is fast enough.
"""

from dataclasses import dataclass

from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.core import World

PATIENCE_S = 1.0  # docs/run.md
GLANCE_S = 0.1  # wall: how late a signal or a deadline may be seen
REMIND_S = 0.05  # wall: far longer than an answer takes, unless it or the odometry was lost


@dataclass(slots=True)
class Pace:
    """How fast one run goes on; `speed` None means lock-step."""

    speed: float | None
    _due_wall_s: float | None = None
    _told_wall_s: float = 0.0

    def wait_s(self, world: World, *, wall_s: float) -> float:
        """How long to wait for arrivals before the next look [wall s]; 0 when a tick is due."""
        if not world.started:
            return GLANCE_S
        if self._due_wall_s is None:
            self._due_wall_s = wall_s + (PATIENCE_S if self._in_lock_step(world) else 0.0)
        if not self._in_lock_step(world):
            return min(max(self._due_wall_s - wall_s, 0.0), GLANCE_S)
        return min(max(self._due_wall_s - wall_s, 0.0), REMIND_S) if world.awaited else 0.0

    def should_remind(self, world: World, *, wall_s: float) -> bool:
        """Whether it is time to tell odometry again to robots that owe an answer; asked means done."""
        if not (self._in_lock_step(world) and world.awaited and wall_s - self._told_wall_s >= REMIND_S):
            return False
        self._told_wall_s = wall_s
        return True

    def ticked(self, world: World, *, wall_s: float) -> None:
        """A tick has been made."""
        assert self._due_wall_s is not None, "ticked before it was due"
        self._told_wall_s = wall_s
        if self._in_lock_step(world):
            self._due_wall_s = wall_s + PATIENCE_S
            return
        period_s = TICK_S / (self.speed or 1.0)
        self._due_wall_s = max(self._due_wall_s + period_s, wall_s - ODOMETRY_TICKS * period_s)

    def _in_lock_step(self, world: World) -> bool:
        return self.speed is None and world.ending is None
