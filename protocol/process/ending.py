"""Requests to end a process with an event loop: signals (`asked`), `FAIL`, the end of the lifeline."""

import asyncio
import contextlib
import os
import signal
from collections.abc import Coroutine, Iterator
from typing import Any

from protocol.exit_codes import ExitCode
from protocol.process.asked import EXIT_CODES, heeded

FAIL = signal.SIGUSR1
"""End, for another process of the run is lost: the run has failed."""


@contextlib.contextmanager
def asked_to_end(lifeline: int | None) -> Iterator[asyncio.Future[ExitCode]]:
    """A future that gets an exit code when this process is asked to end. Enter it in the event loop.

    Args:
        lifeline: a file descriptor to read; its end of file means that our parent process is gone.
    """
    loop = asyncio.get_running_loop()
    asked: asyncio.Future[ExitCode] = loop.create_future()

    def end(exit_code: ExitCode) -> None:
        if not asked.done():
            asked.set_result(exit_code)

    def read() -> None:
        if lifeline is not None and not os.read(lifeline, 4096):
            loop.remove_reader(lifeline)
            end(ExitCode.TERMINATED)

    signals = {number: EXIT_CODES[number] for number in heeded()} | {FAIL: ExitCode.FAILED}
    for number, exit_code in signals.items():
        loop.add_signal_handler(number, end, exit_code)
    if lifeline is not None:
        try:
            loop.add_reader(lifeline, read)
        except PermissionError:  # a file or /dev/null cannot be watched: it has no other end
            end(ExitCode.TERMINATED)
    try:
        yield asked
    finally:
        if lifeline is not None:
            loop.remove_reader(lifeline)
        for number in signals:
            loop.remove_signal_handler(number)


async def until_ended(work: Coroutine[Any, Any, int], lifeline: int | None) -> int:
    """Do the work and return its exit code, or the code of a request to end that comes first."""
    with asked_to_end(lifeline) as asked:
        task = asyncio.ensure_future(work)
        either: list[asyncio.Future[Any]] = [task, asked]
        await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
        if task.done():
            return task.result()
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        return asked.result()
