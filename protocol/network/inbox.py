"""A bounded queue from the network's thread to the event loop. It gets the function that wakes the loop."""

from collections import deque
from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

T = TypeVar("T")

INBOX_CAPACITY = 16_384  # a world of 1000 robots receives 10,000 messages a second: a pause of 1.6 s


class Inbox(Generic[T]):
    """Arrivals in order; a full inbox drops the oldest and counts it.

    `wake` is called once per burst: when something arrives in an empty inbox.
    """

    def __init__(self, wake: Callable[[], None], *, capacity: int) -> None:
        self.dropped_count = 0
        self._wake = wake
        self._items: deque[T] = deque(maxlen=capacity)
        self._lock = Lock()

    def append(self, item: T) -> None:
        """Add an arrival; any thread may call this."""
        with self._lock:
            was_empty = not self._items
            if len(self._items) == self._items.maxlen:
                self.dropped_count += 1  # newest wins: an old state is worse than none
            self._items.append(item)
        if was_empty:
            self._wake()

    def drain(self) -> list[T]:
        """Remove and return all arrivals."""
        with self._lock:
            items = list(self._items)
            self._items.clear()
        return items
