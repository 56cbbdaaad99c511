"""Counts of messages by key, at one process; what the fleet's books are balanced from."""

from collections import Counter
from dataclasses import dataclass, field

REFUSED_KEYS_MAX = 100  # whoever may say anything on any key must not fill our memory, nor our last entry
OTHERS = "others"


@dataclass(slots=True)
class Traffic:
    """What one process sent and received. Pure counting: the shell says what happened."""

    sent: Counter[str] = field(default_factory=Counter)
    received: Counter[str] = field(default_factory=Counter)
    newest: dict[str, int] = field(default_factory=dict)
    """The highest message number that came, by key: what is missing below it was lost."""
    injected: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Messages that a fault plan took away here, by key and fault; such a one does not count as received."""
    refused: Counter[str] = field(default_factory=Counter)
    """Messages that broke the protocol, by key."""
    overflowed_count: int = 0

    def send(self, key: str) -> int:
        """Count one message out; returns its number on that key, from 1."""
        self.sent[key] += 1
        return self.sent[key]

    def receive(self, key: str, number: int) -> None:
        """Count one message in."""
        self.received[key] += 1
        self._note_number(key, number)

    def refuse(self, key: str) -> None:
        """Count one message in that broke the protocol: its number cannot be read."""
        known = key in self.refused or len(self.refused) < REFUSED_KEYS_MAX
        self.refused[key if known else OTHERS] += 1

    def take_away(self, key: str, number: int, fault: str) -> None:
        """Count one message that came, and that a fault plan took away."""
        self.injected[key, fault] += 1
        self._note_number(key, number)

    def take_back(self, key: str, number: int, fault: str) -> None:
        """What was counted in has been taken away by a fault plan."""
        self.received[key] -= 1
        self.take_away(key, number, fault)

    def injected_by_fault(self) -> dict[str, dict[str, int]]:
        """What a fault plan took away here: by fault, then by key."""
        by_fault: dict[str, dict[str, int]] = {}
        for (key, fault), count in sorted(self.injected.items()):
            by_fault.setdefault(fault, {})[key] = count
        return by_fault

    def _note_number(self, key: str, number: int) -> None:
        self.newest[key] = max(number, self.newest.get(key, 0))
