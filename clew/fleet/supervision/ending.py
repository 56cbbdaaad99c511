"""How a run ends: the world is asked, then all others, then what is left is killed.

Rule 1: everything is gone within `Limits.all_s` of the first sign of the end.
Rule 2: the world ends first, because the robots have to be there while it closes its books.
Rule 3: what had to be killed is named where data may be lost by it: a world or a host, before the verdict.
"""

import math
import signal
from collections.abc import Iterator

from clew.fleet.supervision.events import HOST, WORLD, Command, Say, Signal
from clew.fleet.supervision.facts import Facts
from protocol.exit_codes import ExitCode

KEEPS_DATA = (WORLD, HOST)


class Ending:
    """Since when a run ends, who has been asked to, and with what exit code."""

    def __init__(self, facts: Facts) -> None:
        self.since_s = math.inf
        """When the first sign of the end came."""
        self.code: int = ExitCode.OK
        self._facts = facts
        self._asked_s: dict[str, float] = {}

    def begin(self, now_s: float) -> None:
        """This is the first sign of the end, unless there was one."""
        self.since_s = min(self.since_s, now_s)

    def ask_world(
        self, code: int, now_s: float, number: signal.Signals = signal.SIGTERM
    ) -> Iterator[Command]:
        """Have the world write its verdict; what a process fault has frozen is thawed, so that it can."""
        self.begin(now_s)
        self.code = code
        if self._facts.is_running(WORLD):
            self._asked_s[WORLD] = now_s
            yield Signal(WORLD, number)
            yield Signal(WORLD, signal.SIGCONT)  # whoever has frozen it
        for part in self._facts.frozen():
            if part != WORLD:
                yield Signal(part, signal.SIGCONT)

    def ask_all(self, now_s: float) -> Iterator[Command]:
        """Have all others end."""
        for part in self._facts.present():
            self._asked_s.setdefault(part, now_s)
            yield Signal(part, signal.SIGTERM, group=True)
            yield Signal(part, signal.SIGCONT, group=True)

    def kill(self, now_s: float) -> Iterator[Command]:
        """End what has not ended when it was asked to."""
        for part in self._facts.present():
            if part in KEEPS_DATA and not self._facts.judged:
                waited_s = now_s - self._asked_s[part]
                yield Say(f"the {part} had not ended {waited_s:.1f} s after it was asked to, and was killed")
            yield Signal(part, signal.SIGKILL, group=True)
