"""A bounded queue from the network's thread to the task that reads it, and what wakes that task.

Rule 1: the task waits in the event loop, where other tasks run meanwhile (`Alarm`). In a process that has no
        other task it waits beside the loop (`Bell`): there a message costs a third of the system calls.
"""

import asyncio
import contextlib
import math
import os
import select
import selectors
from collections.abc import Callable
from threading import Lock
from typing import Generic, Protocol, TypeVar

from protocol.network.bounded import Bounded
from protocol.process.foreign import keep_thread

T = TypeVar("T")

QUIET_TURNS = 8
"""After so many turns without an event a loop has nothing left to do: a signal takes five to cancel a task.

Turns, and not a time: on a busy machine the time may be over before, and then the task would wait for a bell
that nobody rings, while the loop stands still.
"""


class Inbox(Generic[T]):
    """Arrivals in order; a full inbox drops the oldest and counts them.

    `wake` is called once per burst: when something arrives in an empty inbox.
    """

    def __init__(self, wake: Callable[[], None], *, capacity: int, bytes_max: int) -> None:
        self._wake = wake
        self._waiting: Bounded[T] = Bounded(capacity=capacity, bytes_max=bytes_max)
        self._lock = Lock()

    @property
    def dropped_count(self) -> int:
        """How many arrivals did not fit."""
        return self._waiting.dropped_count

    def append(self, item: T, size_bytes: int) -> None:
        """Add an arrival; any thread may call this, and keeps its state (`protocol.process.foreign`)."""
        keep_thread()
        with self._lock:
            was_empty = len(self._waiting) == 0
            self._waiting.append(item, size_bytes)
        if was_empty:
            self._wake()

    def __len__(self) -> int:
        """How many arrivals wait."""
        return len(self._waiting)

    def drain(self) -> list[T]:
        """Remove and return all arrivals."""
        with self._lock:
            return self._waiting.drain()


class Waking(Protocol):
    """What wakes the one reader."""

    def ring(self) -> None:
        """Wake the reader, if it waits; any thread may call this, even after the loop has ended."""

    async def wait(self, timeout_s: float | None) -> None:
        """Wait until it rings, for so long at most."""


class Alarm:
    """Wakes the one task that waits. It costs one future and one timer: a process waits in every turn."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        """`loop` is that of the task."""
        self._loop = loop
        self._waiting: asyncio.Future[None] | None = None

    def ring(self) -> None:
        """Wake the waiting task, if there is one."""
        with contextlib.suppress(RuntimeError):  # Zenoh ends a query that is open after its session
            self._loop.call_soon_threadsafe(self._end)

    async def wait(self, timeout_s: float | None) -> None:
        """Wait until it rings; other tasks run meanwhile, even if there is no time."""
        if timeout_s is not None and timeout_s <= 0.0:
            await asyncio.sleep(0)
            return
        self._waiting = self._loop.create_future()
        timer = None if timeout_s is None else self._loop.call_later(timeout_s, self._end)
        try:
            await self._waiting
        finally:
            self._waiting = None
            if timer is not None:
                timer.cancel()

    def _end(self) -> None:
        if self._waiting is not None and not self._waiting.done():
            self._waiting.set_result(None)


class _CountingSelector(selectors.EpollSelector):
    """Counts the turns of a loop since its last event."""

    quiet_turns = 0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        events = super().select(timeout)
        self.quiet_turns = 0 if events else self.quiet_turns + 1
        return events


class OneTaskLoop(asyncio.SelectorEventLoop):
    """The event loop of a process with one task, beside signals and files that end it."""

    def __init__(self) -> None:
        self.selector = _CountingSelector()
        super().__init__(self.selector)

    async def serve(self) -> None:
        """Do what signals and files ask for, until nothing of it is left."""
        await asyncio.sleep(0)
        while self.selector.quiet_turns < QUIET_TURNS:  # noqa: ASYNC110 - it lets the loop turn, and waits for nothing
            await asyncio.sleep(0)


class Bell:
    """Wakes the thread of a loop with one task: it waits for the bell and for the files of the loop."""

    def __init__(self, loop: OneTaskLoop) -> None:
        self._rung = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._loop = loop
        # No epoll: Linux lets at most 500 of these watch others that watch one file, as all robots' loops do.
        self._either = select.poll()
        for each in (self._rung, loop.selector.fileno()):
            self._either.register(each, select.POLLIN)

    def ring(self) -> None:
        """Wake the reader, now or when it waits next."""
        os.eventfd_write(self._rung, 1)

    async def wait(self, timeout_s: float | None) -> None:
        """Wait until it rings, or the loop has something to do."""
        ready = self._either.poll(None if timeout_s is None else math.ceil(timeout_s * 1000.0))
        for file, _ in ready:
            if file == self._rung:
                os.eventfd_read(self._rung)
            else:
                await self._loop.serve()


def alarm(loop: asyncio.AbstractEventLoop) -> Waking:
    """What wakes the one reader in this loop."""
    return Bell(loop) if isinstance(loop, OneTaskLoop) else Alarm(loop)
