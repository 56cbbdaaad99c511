"""A queue that is bounded in items and in bytes: a full one drops its oldest items and counts them. Pure."""

from collections import deque
from typing import Generic, TypeVar

from protocol.wire.codec import SIZE_MAX_BYTES

T = TypeVar("T")

INBOX_CAPACITY = 16_384  # a world of 1000 robots receives 10,000 messages a second: a pause of 1.6 s
INBOX_BYTES_MAX = 512 * SIZE_MAX_BYTES  # 32 MiB: in 1.6 s, a world of 1000 robots receives less than 8 MB


class Bounded(Generic[T]):
    """Items in order of arrival."""

    def __init__(self, *, capacity: int, bytes_max: int) -> None:
        self.dropped_count = 0
        self._capacity, self._bytes_max = capacity, bytes_max
        self._items: deque[tuple[T, int]] = deque()
        self._bytes = 0

    def __len__(self) -> int:
        """The number of items that wait."""
        return len(self._items)

    def append(self, item: T, size_bytes: int) -> None:
        """Add an item. The newest wins: an old state is worse than none."""
        self._items.append((item, size_bytes))
        self._bytes += size_bytes
        while len(self._items) > self._capacity or self._bytes > self._bytes_max:
            _, dropped_bytes = self._items.popleft()
            self._bytes -= dropped_bytes
            self.dropped_count += 1

    def drain(self) -> list[T]:
        """Remove and return all items."""
        items = [item for item, _ in self._items]
        self._items.clear()
        self._bytes = 0
        return items
