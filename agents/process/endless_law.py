"""A robot records that a law of a user does not return, since until then it does nothing else. A shell.

Rule 1: an alarm looks every `ALARM_S` which call of the law goes on. A call that two alarms in a row find has
        not returned for that long, even if the process was frozen in between. It is recorded once.
Rule 2: Python looks at alarms between two of its instructions. So a law that never comes back from a library
        in C is not found.
Rule 3: laws of ours return: for them there is no alarm.
"""

import signal
from collections.abc import Callable
from pathlib import Path
from types import FrameType

from agents.navigation.law import call_in
from protocol.laws import OURS
from protocol.timeline import LawStalled, Record

ALARM_S = 5.0  # wall: three times the longest plan of a law of ours on a busy machine


class Watch:
    """The call of a law that goes on."""

    def __init__(self, law: str, record: Callable[[Record], None]) -> None:
        self._law, self._record = law, record
        self._call: FrameType | None = None
        """The call that the last alarm found: the object is kept, so no later call can be taken for it."""
        self._is_told = False
        """Whether it has been recorded."""

    def look(self, _number: int, frame: FrameType | None) -> None:
        """Hear an alarm, which has interrupted this frame."""
        before, self._call = self._call, call_in(frame)
        if frame is None or self._call is None or self._call is not before:
            self._is_told = False
            return
        if self._is_told:
            return
        self._is_told = True
        at = f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"
        self._record(LawStalled(law=self._law, after_s=ALARM_S, at=at))


def watch_law(law: str, record: Callable[[Record], None]) -> None:
    """Watch a law of a user from now on, in this process; `record` is called in the middle of its call."""
    if law not in OURS:
        signal.signal(signal.SIGALRM, Watch(law, record).look)
        signal.setitimer(signal.ITIMER_REAL, ALARM_S, ALARM_S)
