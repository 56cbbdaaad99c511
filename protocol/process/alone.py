"""A process with one task and without an event loop: what wakes the task, and what ends it.

An event loop costs a robot a fifth of what it computes before it connects, and a tenth of its memory. Beside
the loop a message costs a third of the system calls.

Rule 1: the task waits for its bell, and for nothing else. Signals and files are heard only there.
Rule 2: the first request to end is raised where the task waits: a signal (`ending`), or the end of the
        lifeline. So a step is always whole, and the task's contexts are left as after a failure.
"""

import contextlib
import math
import os
import select
import signal
from collections.abc import Callable, Coroutine, Iterator
from typing import Any, TypeVar

from protocol.exit_codes import ExitCode
from protocol.process.ending import requests

T = TypeVar("T")


class Ended(BaseException):  # no Exception: what handles errors does not handle this
    """The process is asked to end (rule 2)."""

    def __init__(self, exit_code: ExitCode) -> None:
        super().__init__(exit_code)
        self.exit_code = exit_code


class Bell:
    """Wakes the one task of a process. It opens files, which stay open until the process ends."""

    def __init__(self, lifeline: int | None) -> None:
        """`lifeline` is a file to read; its end means that our parent process is gone."""
        self._lifeline = lifeline
        self._rung = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._signals, self._signals_end = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
        self._any = select.poll()
        for each in (self._rung, self._signals, *(() if lifeline is None else (lifeline,))):
            self._any.register(each, select.POLLIN)
        self._requests = requests()

    def ring(self) -> None:
        """Wake the task, now or when it waits next; any thread may call this."""
        os.eventfd_write(self._rung, 1)

    async def wait(self, timeout_s: float | None) -> None:
        """Wait until it rings, for so long at most.

        Raises:
            Ended: the process is asked to end.
        """
        for file, _ in self._any.poll(None if timeout_s is None else math.ceil(timeout_s * 1000.0)):
            if file == self._rung:
                os.eventfd_read(self._rung)
            elif file == self._signals:
                self._hear_signal(os.read(file, 1)[0])
            elif not os.read(file, 4096):
                raise Ended(ExitCode.TERMINATED)

    def _hear_signal(self, number: int) -> None:
        for request, exit_code in self._requests.items():  # others are handled where they arrive
            if request == number:
                raise Ended(exit_code)

    @contextlib.contextmanager
    def hears_signals(self) -> Iterator[None]:
        """Hear these signals; enter it in the main thread."""
        # By the pipe: handlers run between two instructions, which is too late for a wait that begins there.
        before = {number: signal.signal(number, _take) for number in self._requests}
        for number in before:
            signal.siginterrupt(number, False)  # system calls are restarted
        wakes = signal.set_wakeup_fd(self._signals_end, warn_on_full_buffer=False)
        try:
            yield
        finally:
            signal.set_wakeup_fd(wakes)
            for number, handler in before.items():
                signal.signal(number, handler)


def _take(_number: int, _frame: object) -> None:
    """A signal: the pipe tells it."""


def run_alone(work: Callable[[Bell], Coroutine[Any, Any, T]], lifeline: int | None) -> T | ExitCode:
    """Do the work, which waits for the bell alone; returns its result, or the code of a request to end."""
    bell = Bell(lifeline)
    with bell.hears_signals():
        try:
            work(bell).send(None)
        except StopIteration as done:
            result: T = done.value
            return result
        except Ended as ended:
            return ended.exit_code
    raise AssertionError("the task waits for something else than its bell")
