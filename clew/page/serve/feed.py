"""The messages to the pages of one run, in the same order for all. Pure: no file, no socket.

Rule 1: every message is kept once, for all pages. A page is only a place in this list: a slow or late page
        takes no memory and misses nothing.
Rule 2: a message's id is TELLING-NUMBER. A reconnecting `EventSource` sends the newest id that it has seen
        and continues after it. After an id of another telling, the page is told to restart: it shows another
        run or the same run in other messages.
"""

import re
from dataclasses import dataclass, field

ID = re.compile(r"([0-9a-f]{1,32})-([0-9]{1,9})")
ANEW = b"event: anew\ndata:\n\n"


@dataclass(frozen=True, slots=True)
class Place:
    """The place of a page in the list of messages."""

    telling: str
    """Empty: there was no run yet."""
    number: int = 0


@dataclass(slots=True)
class Feed:
    """All messages of the current run."""

    telling: str = ""
    """Empty until a run is there."""
    _messages: list[bytes] = field(default_factory=list)

    def begin(self, telling: str) -> None:
        """Begin a run from its start; all earlier messages are void. The name is hexadecimal and new."""
        self.telling, self._messages = telling, []

    def tell(self, text: bytes) -> None:
        """Append a message of a single line."""
        assert self.telling, "no run is told yet"
        assert b"\n" not in text, text[:80]
        number = len(self._messages) + 1
        self._messages.append(b"id: %s-%d\ndata: %s\n\n" % (self.telling.encode(), number, text))

    def place(self, newest_id: str | None) -> Place:
        """The place after this id; without an id, or with a foreign one, the start."""
        match = ID.fullmatch(newest_id or "")
        return Place(match[1], int(match[2])) if match else Place(self.telling)

    def next(self, place: Place) -> tuple[bytes, Place] | None:
        """The next message and the place after it; None: there is nothing new."""
        if place.telling not in {"", self.telling}:
            return ANEW, Place(self.telling)
        if place.number >= len(self._messages):
            return None
        return self._messages[place.number], Place(self.telling, place.number + 1)
