"""How a verb without an event loop is asked to end: Ctrl-C, SIGTERM, or SIGHUP where its terminal goes.

Rule 1: `terminable` ends it in the midst of whatever it does, as Ctrl-C would.
Rule 2: `asked_to_end` only tells it, for what has to come to its own end: a run to judge, a fleet to stop.
Rule 3: what was to be ignored when we were started still is: `nohup` says so of SIGHUP.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from protocol.exit_codes import ExitCode

EXIT_CODES: dict[int, ExitCode] = {
    signal.SIGINT: ExitCode.INTERRUPTED,
    signal.SIGTERM: ExitCode.TERMINATED,
    signal.SIGHUP: ExitCode.HUNG_UP,
}


class AskedToEnd(KeyboardInterrupt):
    """One of the signals has come. Whoever ends well on Ctrl-C ends well on this."""

    def __init__(self, exit_code: ExitCode) -> None:
        super().__init__()
        self.exit_code = exit_code


@contextmanager
def terminable() -> Iterator[None]:
    """The first of the signals raises `AskedToEnd`; decorates a verb as well."""
    asked: list[ExitCode] = []

    def end(exit_code: ExitCode) -> None:
        asked.append(exit_code)
        if len(asked) == 1:  # `timeout` says it twice, and the second is not to disturb the end
            raise AskedToEnd(exit_code)

    with _heard_by(end):
        yield


@contextmanager
def asked_to_end() -> Iterator[list[ExitCode]]:
    """A list that gets an exit code whenever this process is asked to end."""
    asked: list[ExitCode] = []
    with _heard_by(asked.append):
        yield asked


@contextmanager
def _heard_by(hear: Callable[[ExitCode], None]) -> Iterator[None]:
    def handle(number: int, _frame: FrameType | None) -> None:
        hear(EXIT_CODES[number])

    heard = [number for number in EXIT_CODES if signal.getsignal(number) is not signal.SIG_IGN]
    before = {number: signal.signal(number, handle) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
