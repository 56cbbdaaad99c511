"""A law of a user that does not return: which one it is, and how Ctrl-C still ends its rehearsal.

Rule 1: a request to end is obeyed between two events (`rehearsal`, rule 4). Such a law lets none come.
Rule 2: `PATIENCE_S` after a request, `LawStoppedError` is raised in a user's law that is still asked, and
        nowhere else. So that law has failed (`agents.navigation.law`, rule 3), and the run has a verdict.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from agents.navigation.law import call_in
from protocol.exit_codes import ExitCode
from protocol.process.asked import asked_to_end

PATIENCE_S = 2.0  # a law that computes for long returns by then; a user does not wait much longer


class LawStoppedError(Exception):
    """The user has asked the rehearsal to end, and this law has not returned since."""


def law_in(frame: FrameType | None) -> str | None:
    """The law of a user that is asked in this frame or in a caller of it."""
    call = call_in(frame)
    return None if call is None else str(call.f_locals["name"])


@contextmanager
def asked_to_end_in_laws() -> Iterator[list[ExitCode]]:
    """As `asked_to_end`, but a law of a user that does not return is stopped, too (rule 2)."""

    def strike(_number: int, frame: FrameType | None) -> None:
        if law_in(frame) is not None:
            raise LawStoppedError(f"it had not returned {PATIENCE_S:g} s after the request to end")

    before = signal.signal(signal.SIGALRM, strike)
    try:
        with asked_to_end(lambda: signal.setitimer(signal.ITIMER_REAL, PATIENCE_S, PATIENCE_S)) as asked:
            yield asked
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
