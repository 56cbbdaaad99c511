"""Schedules ticks against the wall clock. Pure: the time is an argument.

Rule 1: no tick is skipped; a late world runs slower. It catches up by at most one odometry period, since
        robots could not answer a longer burst in time.
Rule 2: in lock-step the world ticks at once, unless answers of robots are missing. It waits `PATIENCE_S` for
        them at most. Odometry is state, so it is sent again to such a robot: a message may be lost.
Rule 3: when the run is over robots do not answer, and the world ticks in real time.
"""

from dataclasses import dataclass

from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.core import World

PATIENCE_S = 1.0  # docs/run.md
GLANCE_S = 0.1  # wall: the longest delay in noticing a signal or a deadline
REMIND_S = 0.05  # wall: far longer than an answer takes if no message is lost


@dataclass(slots=True)
class Pace:
    """The pace of one run; `speed` None means lock-step."""

    speed: float | None
    _due_wall_s: float | None = None
    _told_wall_s: float = 0.0

    def wait_s(self, world: World, *, wall_s: float) -> float:
        """How long to wait for arrivals [wall s]; 0 when a tick is due."""
        if not world.started:
            return GLANCE_S
        if self._due_wall_s is None:
            self._due_wall_s = wall_s + (PATIENCE_S if self._in_lock_step(world) else 0.0)
        if not self._in_lock_step(world):
            return min(max(self._due_wall_s - wall_s, 0.0), GLANCE_S)
        return min(max(self._due_wall_s - wall_s, 0.0), REMIND_S) if world.awaited else 0.0

    def take_reminder(self, world: World, *, wall_s: float) -> bool:
        """Whether to send odometry again to robots that have not answered; True restarts the period."""
        if not (self._in_lock_step(world) and world.awaited and wall_s - self._told_wall_s >= REMIND_S):
            return False
        self._told_wall_s = wall_s
        return True

    def ticked(self, world: World, *, wall_s: float) -> None:
        """Note that a tick was made."""
        assert self._due_wall_s is not None, "ticked before it was due"
        self._told_wall_s = wall_s
        if self._in_lock_step(world):
            self._due_wall_s = wall_s + PATIENCE_S
            return
        period_s = TICK_S / (self.speed or 1.0)
        self._due_wall_s = max(self._due_wall_s + period_s, wall_s - ODOMETRY_TICKS * period_s)

    def _in_lock_step(self, world: World) -> bool:
        return self.speed is None and world.ending is None
