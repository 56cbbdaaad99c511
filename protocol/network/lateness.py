"""How late a process runs, as it measures it itself. Pure: times are arguments.

Rule 1: a turn of the event loop is late by the time in which it neither computed nor was asked to wait. So a
        long computation is not lateness: only a machine that has no time for the process is.
Rule 2: a turn that took longer than `LATE_S_MAX` was a stopped process, and says nothing about the machine.
Rule 3: the longest recent delay counts: it is halved every `HALF_LIFE_S`.
"""

import math
from dataclasses import dataclass

from protocol.wire.messages import LATE_S_MAX

HALF_LIFE_S = 30.0  # wall: a machine that was late half a minute ago may be so again; 5 s were too short


@dataclass(slots=True)
class Lateness:
    """The lateness of one process [wall s], or the greatest one that it was told."""

    _late_s: float = 0.0
    _at_s: float = 0.0
    _turned: tuple[float, float, float] | None = None
    """When the last turn began, by the wall clock and by `busy_s`, and its longest wait."""

    def turn(self, wall_s: float, busy_s: float, *, asked_s: float) -> None:
        """A turn of the loop begins, so the last has ended; in this one it waits for `asked_s` at most.

        `busy_s` is the time for which this thread has computed so far.
        """
        if self._turned is not None:
            began_wall_s, began_busy_s, last_asked_s = self._turned
            took_s = wall_s - began_wall_s
            if took_s <= LATE_S_MAX:
                self.hear(took_s - (busy_s - began_busy_s) - last_asked_s, wall_s)
        self._turned = (wall_s, busy_s, asked_s)

    def hear(self, late_s: float, wall_s: float) -> None:
        """Take in how late a turn was, of this process or of another one that tells it."""
        self._late_s, self._at_s = max(self.now_s(wall_s), late_s), wall_s

    def now_s(self, wall_s: float) -> float:
        """How late it has been lately (rule 3)."""
        if self._late_s == 0.0:
            return 0.0  # as on an idle machine, and in every rehearsal
        return self._late_s * math.pow(0.5, (wall_s - self._at_s) / HALF_LIFE_S)
