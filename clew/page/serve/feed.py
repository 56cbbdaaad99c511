"""What the pages of one run are told, all of them in one order. Pure: no file, no socket.

Rule 1: every message is kept once, for all pages. A page is a place in this list and nothing else: one that
        is slow, or comes late, takes no memory and misses nothing.
Rule 2: a message's id is TELLING-NUMBER. `EventSource` hands in the newest id that it has seen when it comes
        back, and goes on behind it. After an id of another telling, a page is told to begin anew: what it
        shows is another run, or the same run cut into other messages.
"""

import re
from dataclasses import dataclass, field

ID = re.compile(r"([0-9a-f]{1,32})-([0-9]{1,9})")
ANEW = b"event: anew\ndata:\n\n"


@dataclass(frozen=True, slots=True)
class Place:
    """How far a page has been told."""

    telling: str
    """None: it is empty."""
    number: int = 0


@dataclass(slots=True)
class Feed:
    """All messages of the run that is told now."""

    telling: str = ""
    """Empty until a run is there."""
    _messages: list[bytes] = field(default_factory=list)

    def begin(self, telling: str) -> None:
        """A run is told from its start; whatever was told before is void. The name is hexadecimal and new."""
        self.telling, self._messages = telling, []

    def tell(self, text: bytes) -> None:
        """Append a message, which is a single line."""
        assert self.telling, "no run is told yet"
        assert b"\n" not in text, text[:80]
        number = len(self._messages) + 1
        self._messages.append(b"id: %s-%d\ndata: %s\n\n" % (self.telling.encode(), number, text))

    def place(self, newest_id: str | None) -> Place:
        """Where a page goes on that has seen this id; with none, or one that is not ours, at the start."""
        match = ID.fullmatch(newest_id or "")
        return Place(match[1], int(match[2])) if match else Place(self.telling)

    def next(self, place: Place) -> tuple[bytes, Place] | None:
        """The next message and the place behind it; None: there is nothing new."""
        if place.telling not in {"", self.telling}:
            return ANEW, Place(self.telling)
        if place.number >= len(self._messages):
            return None
        return self._messages[place.number], Place(self.telling, place.number + 1)
