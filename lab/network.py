"""The network of a rehearsal: a heap of messages due, in virtual time. The seed decides their fate."""

import heapq
from collections import Counter
from dataclasses import dataclass
from itertools import count
from random import Random
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkFaults:
    """What a network does to a message."""

    delay_s_max: float = 0.0
    loss_probability: float = 0.0
    repeat_probability: float = 0.0

    def __post_init__(self) -> None:
        for name in ("loss_probability", "repeat_probability"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"{name} must be in [0, 1], got {value}")
        if self.delay_s_max < 0.0:
            raise ValueError(f"delay_s_max must be >= 0 s, got {self.delay_s_max}")


class Network(Generic[T]):
    """Messages on their way. Delays differ, so they overtake each other."""

    def __init__(self, faults: NetworkFaults, random: Random) -> None:
        self.fates: Counter[str] = Counter()
        """How many messages were sent, lost and repeated."""
        self._faults = faults
        self._random = random
        self._due: list[tuple[float, int, T]] = []
        self._ties = count()  # messages due together keep their order, and are never compared

    def send(self, message: T, now_s: float) -> None:
        """Hand a message to the network."""
        self.fates["sent"] += 1
        copies = 1
        if self._random.random() < self._faults.loss_probability:
            self.fates["lost"] += 1
            copies = 0
        elif self._random.random() < self._faults.repeat_probability:
            self.fates["repeated"] += 1
            copies = 2
        for _ in range(copies):
            due_s = now_s + self._random.uniform(0.0, self._faults.delay_s_max)
            heapq.heappush(self._due, (due_s, next(self._ties), message))

    def next_due(self, now_s: float) -> T | None:
        """The next message that has arrived by now; None when there is none."""
        if not self._due or self._due[0][0] > now_s:
            return None
        return heapq.heappop(self._due)[2]
