"""Counts of messages by key, at one process; what the fleet's books are balanced from."""

from collections import Counter
from dataclasses import dataclass, field


@dataclass(slots=True)
class Traffic:
    """What one process sent and received. Pure counting: the shell says what happened."""

    sent: Counter[str] = field(default_factory=Counter)
    received: Counter[str] = field(default_factory=Counter)
    newest: dict[str, int] = field(default_factory=dict)
    """The highest message number that came, by key: what is missing below it was lost."""
    injected: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Messages that a fault plan took away here, by key and fault; such a one does not count as received."""
    refused_count: int = 0
    overflowed_count: int = 0

    def send(self, key: str) -> int:
        """Count one message out; returns its number on that key, from 1."""
        self.sent[key] += 1
        return self.sent[key]

    def receive(self, key: str, number: int) -> None:
        """Count one message in."""
        self.received[key] += 1
        self._note_number(key, number)

    def take_away(self, key: str, number: int, fault: str) -> None:
        """Count one message that came, and that a fault plan took away."""
        self.injected[key, fault] += 1
        self._note_number(key, number)

    def _note_number(self, key: str, number: int) -> None:
        self.newest[key] = max(number, self.newest.get(key, 0))
