"""How a process is asked to end: SIGTERM, SIGINT, or the end of its lifeline."""

import asyncio
import contextlib
import os
import signal
from collections.abc import Coroutine, Iterator
from typing import Any

TERMINATED_EXIT_CODE = 128 + signal.SIGTERM
INTERRUPTED_EXIT_CODE = 128 + signal.SIGINT  # 130, as shells have it


@contextlib.contextmanager
def asked_to_end(lifeline: int | None) -> Iterator[asyncio.Future[int]]:
    """A future that gets an exit code when this process is asked to end. Enter it in the event loop.

    Args:
        lifeline: a file descriptor to read from; its end of file means that whoever started us is gone.
    """
    loop = asyncio.get_running_loop()
    asked: asyncio.Future[int] = loop.create_future()

    def end(exit_code: int) -> None:
        if not asked.done():
            asked.set_result(exit_code)

    def read() -> None:
        if lifeline is not None and not os.read(lifeline, 4096):
            loop.remove_reader(lifeline)
            end(TERMINATED_EXIT_CODE)

    signals = {signal.SIGTERM: TERMINATED_EXIT_CODE, signal.SIGINT: INTERRUPTED_EXIT_CODE}
    for number, exit_code in signals.items():
        loop.add_signal_handler(number, end, exit_code)
    if lifeline is not None:
        try:
            loop.add_reader(lifeline, read)
        except PermissionError:  # a file, or /dev/null, cannot be watched: nobody holds its other end
            end(TERMINATED_EXIT_CODE)
    try:
        yield asked
    finally:
        if lifeline is not None:
            loop.remove_reader(lifeline)
        for number in signals:
            loop.remove_signal_handler(number)


async def until_ended(work: Coroutine[Any, Any, int], lifeline: int | None) -> int:
    """Do the work and return its exit code, or the one of whoever asks us to end before it is done."""
    with asked_to_end(lifeline) as asked:
        task = asyncio.ensure_future(work)
        await asyncio.wait([task, asked], return_when=asyncio.FIRST_COMPLETED)
        if task.done():
            return task.result()
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
        return asked.result()
