"""Whether a run without new entries is over, or only quiet.

Rule 1: a run that was written to within the last `QUIET_S` may go on: its world may be judging, or dead and
        about to be started again. The times of the files say so, and a run of yesterday is over at once.
Rule 2: after that it is over, unless `run.ended` is missing and its world can be reached.
"""

import contextlib
import math
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from protocol.faults.manual_faults import is_running
from world.judge.verdict import VERDICT_FILE

QUIET_S = 10.0  # wall clock: a world judges a million entries in less, and a dead one is started again sooner


@dataclass(slots=True)
class Vigil:
    """Watches one run."""

    events: Path
    _reached_s: float = -math.inf
    """When its world was last reached [monotonic s]; each question takes a connection."""

    def is_over(self, *, ended: bool) -> bool:
        """Whether nobody writes any more; `ended`: `run.ended` has been read."""
        return _age_s(self.events) >= QUIET_S and (ended or not self._is_there())

    def _is_there(self) -> bool:
        now_s = time.monotonic()
        if now_s - self._reached_s >= QUIET_S and is_running(self.events.parent):
            self._reached_s = now_s
        return now_s - self._reached_s < QUIET_S


def stats_of(events: Path) -> Iterator[os.stat_result]:
    """The file status of a log and of the verdict beside it, if they exist."""
    for path in (events, events.with_name(VERDICT_FILE)):
        with contextlib.suppress(OSError):
            yield path.stat()


def _age_s(events: Path) -> float:
    """How long ago a run was written to; a time in the future does not count as recent."""
    return min((abs(time.time() - stat.st_mtime) for stat in stats_of(events)), default=0.0)
