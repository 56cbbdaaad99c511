"""A source's timeline entries on their way to the recorder. Pure: time is an argument.

Rule 1: entries are numbered from 1 and kept until the recorder has acknowledged them.
Rule 2: what has not been acknowledged `resend_s` after it was sent is sent again, and with it all behind it:
        the recorder takes nothing beyond a hole. Else, one batch lost, each entry would be sent twice.
Rule 3: an acknowledgement of another incarnation's entries says nothing of these.
Rule 4: a full outbox takes no new entry, and counts it. To drop an old one instead would leave a hole
        that the recorder asks for until the end.
"""

from collections import deque
from dataclasses import dataclass

from protocol.timeline import Entry, Record
from protocol.wire.codec import SIZE_MAX_BYTES, packed
from protocol.wire.messages import LogBatch, Logged

BATCH_ENTRIES_MAX = 256  # what a `LogBatch` may hold
BATCH_BYTES_MAX = SIZE_MAX_BYTES - 256  # the rest is the envelope's, which takes less than 40


@dataclass(slots=True)
class _Kept:
    """An entry that the recorder has not acknowledged."""

    entry: Entry
    size_bytes: int
    sent_s: float | None = None


class Outbox:
    """Numbers entries, and says which to send next."""

    def __init__(self, incarnation: str = "", *, resend_s: float = 0.3, capacity: int = 10_000) -> None:
        """By default re-send after a hundred times what an acknowledgement takes on one machine."""
        self.lost_count = 0
        self._incarnation = incarnation
        self._resend_s = resend_s
        self._capacity = capacity
        self._kept: deque[_Kept] = deque()
        self._newest = 0

    def __len__(self) -> int:
        """How many entries the recorder has not acknowledged."""
        return len(self._kept)

    def add(self, record: Record, *, t_s: float, hlc: str) -> None:
        """Keep a new entry until it is acknowledged; it has not been sent yet."""
        if len(self._kept) == self._capacity:
            self.lost_count += 1
            return
        entry = Entry(n=self._newest + 1, t_s=t_s, hlc=hlc, record=record)
        size_bytes = len(packed(entry))
        assert size_bytes <= BATCH_BYTES_MAX, f"{type(record).__name__} takes {size_bytes} bytes"
        self._newest = entry.n
        self._kept.append(_Kept(entry, size_bytes))

    def batch(self, now_s: float) -> LogBatch | None:
        """The next entries to send, taken as sent; None when there is nothing to send. Ask until then."""
        entries: list[Entry] = []
        room_bytes = BATCH_BYTES_MAX
        for kept in self._kept:
            if not entries and kept.sent_s is not None and now_s - kept.sent_s < self._resend_s:
                continue
            room_bytes -= kept.size_bytes
            if room_bytes < 0 or len(entries) == BATCH_ENTRIES_MAX:
                break
            kept.sent_s = now_s
            entries.append(kept.entry)
        return LogBatch(incarnation=self._incarnation, entries=tuple(entries)) if entries else None

    def acknowledged(self, logged: Logged) -> None:
        """The recorder has written every entry up to some number; what was never sent it cannot have."""
        if logged.incarnation != self._incarnation:
            return
        up_to = logged.up_to
        while self._kept and self._kept[0].entry.n <= up_to and self._kept[0].sent_s is not None:
            self._kept.popleft()
