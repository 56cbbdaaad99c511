"""Signals that ask a verb without an event loop to end: SIGINT (Ctrl-C), SIGTERM, SIGHUP (terminal closed).

Rule 1: `terminable` interrupts the verb at once, as Ctrl-C does.
Rule 2: `asked_to_end` only reports the signal, for verbs that must finish: judge a run, stop a fleet.
Rule 3: signals that were ignored at our start stay ignored: `nohup` ignores SIGHUP, for example.
"""

import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import Any

from protocol.exit_codes import ExitCode

EXIT_CODES: Mapping[signal.Signals, ExitCode] = {
    signal.SIGINT: ExitCode.INTERRUPTED,
    signal.SIGTERM: ExitCode.TERMINATED,
    signal.SIGHUP: ExitCode.HUNG_UP,
}
"""What a process exits with that such a signal has ended; with an event loop, too (`ending`)."""

Handler = Callable[[int, FrameType | None], Any] | int | None  # the type of the standard library


def signal_of(exit_code: int) -> signal.Signals | None:
    """The signal after which a process exits with this code; None: the code is of none of these signals."""
    return next((number for number, code in EXIT_CODES.items() if code == exit_code), None)


def heeded() -> list[signal.Signals]:
    """Rule 3: these signals without those that were ignored at our start."""
    return [number for number in EXIT_CODES if signal.getsignal(number) is not signal.SIG_IGN]


class AskedToEnd(KeyboardInterrupt):
    """One of the signals has arrived. Code that ends cleanly on Ctrl-C ends cleanly on this."""

    def __init__(self, exit_code: ExitCode) -> None:
        super().__init__()
        self.exit_code = exit_code


@contextmanager
def terminable() -> Iterator[list[ExitCode]]:
    """The first signal raises `AskedToEnd`; also usable as a decorator. The list gets a code for each."""
    asked: list[ExitCode] = []

    def end(exit_code: ExitCode) -> None:
        asked.append(exit_code)
        if len(asked) == 1:  # `timeout` sends two signals; the second must not disturb the end
            raise AskedToEnd(exit_code)

    with _heard_by(end):
        yield asked


@contextmanager
def asked_to_end(then: Callable[[], object] = lambda: None) -> Iterator[list[ExitCode]]:
    """A list that gets an exit code for each signal that asks this process to end; `then` is called, too."""
    asked: list[ExitCode] = []

    def end(exit_code: ExitCode) -> None:
        asked.append(exit_code)
        then()

    with _heard_by(end):
        yield asked


def listen(hear: Callable[[ExitCode], None]) -> Mapping[int, Handler]:
    """Handle these signals from now on; returns the former handlers."""

    def handle(number: int, _frame: FrameType | None) -> None:
        hear(EXIT_CODES[signal.Signals(number)])

    return {number: signal.signal(number, handle) for number in heeded()}


def ignore() -> None:
    """Ignore these signals from now on: the process exits with a known code."""
    for number in EXIT_CODES:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def _heard_by(hear: Callable[[ExitCode], None]) -> Iterator[None]:
    before = listen(hear)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
