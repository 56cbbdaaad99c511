"""When to tick, against the wall clock. Pure: the time is an argument.

Rule 1: no tick is skipped; a world that is late runs slower. It makes up for at most one odometry period,
        since a longer burst would outrun the robots that answer it.
Rule 2: in lock-step it ticks at once, unless robots owe an answer, and waits for those `PATIENCE_S` at most.
Rule 3: when the run is over nobody answers, and real time is fast enough.
"""

from dataclasses import dataclass

from world.core import ODOMETRY_TICKS, TICK_S, World

PATIENCE_S = 1.0  # docs/run.md
GLANCE_S = 0.1  # wall: how late a signal or a deadline may be seen


@dataclass(slots=True)
class Pace:
    """How fast one run goes on; `speed` None means lock-step."""

    speed: float | None
    _due_wall_s: float | None = None

    def wait_s(self, world: World, *, wall_s: float) -> float:
        """How long to wait for arrivals before the next look [wall s]; 0 when a tick is due."""
        if not world.started:
            return GLANCE_S
        if self._due_wall_s is None:
            self._due_wall_s = wall_s + (PATIENCE_S if self._in_lock_step(world) else 0.0)
        if self._in_lock_step(world) and not world.awaited:
            return 0.0
        return min(max(self._due_wall_s - wall_s, 0.0), GLANCE_S)

    def ticked(self, world: World, *, wall_s: float) -> None:
        """A tick has been made."""
        assert self._due_wall_s is not None, "ticked before it was due"
        if self._in_lock_step(world):
            self._due_wall_s = wall_s + PATIENCE_S
            return
        period_s = TICK_S / (self.speed or 1.0)
        self._due_wall_s = max(self._due_wall_s + period_s, wall_s - ODOMETRY_TICKS * period_s)

    def _in_lock_step(self, world: World) -> bool:
        return self.speed is None and world.ending is None
