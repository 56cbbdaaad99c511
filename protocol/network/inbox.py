"""A bounded queue from the network's thread to the event loop. It gets the function that wakes the loop."""

from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

from protocol.network.bounded import Bounded

T = TypeVar("T")


class Inbox(Generic[T]):
    """Arrivals in order; a full inbox drops the oldest and counts them.

    `wake` is called once per burst: when something arrives in an empty inbox.
    """

    def __init__(self, wake: Callable[[], None], *, capacity: int, bytes_max: int) -> None:
        self._wake = wake
        self._waiting = Bounded[T](capacity=capacity, bytes_max=bytes_max)
        self._lock = Lock()

    @property
    def dropped_count(self) -> int:
        """How many arrivals did not fit."""
        return self._waiting.dropped_count

    def append(self, item: T, size_bytes: int) -> None:
        """Add an arrival; any thread may call this."""
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
