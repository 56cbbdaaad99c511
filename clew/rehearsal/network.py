"""The network of a rehearsal: a heap of messages due, in virtual time. Faults decide when and how often."""

import heapq
from itertools import count
from typing import Generic, TypeVar

T = TypeVar("T")


class Network(Generic[T]):
    """Messages in transit, ordered by the time at which they are due."""

    def __init__(self) -> None:
        self._due: list[tuple[float, int, T]] = []
        self._ties = count()  # messages due together keep their order and are not compared

    def send(self, message: T, due_s: float) -> None:
        """Let a message arrive at `due_s`."""
        heapq.heappush(self._due, (due_s, next(self._ties), message))

    def next_due(self, now_s: float) -> T | None:
        """The next message that is due by now; None if there is none."""
        if not self._due or self._due[0][0] > now_s:
            return None
        return heapq.heappop(self._due)[2]
