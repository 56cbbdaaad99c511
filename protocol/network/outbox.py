"""Sends a source's timeline entries to the recorder. Pure: time is an argument.

Rule 1: entries are numbered from 1 and kept until the recorder has acknowledged them.
Rule 2: an entry without acknowledgement is sent again after `resend_s`, together with all later entries,
        since the recorder accepts nothing beyond a gap. Otherwise one lost batch would make every entry be
        sent twice.
Rule 3: acknowledgements of another incarnation are ignored.
Rule 4: an outbox that is full, in entries or in bytes, refuses new entries and counts them. If it dropped an
        old entry, the gap would stay until the end of the run.
Rule 5: what a peer says must not crowd out what this process does: an entry on a refused message finds no
        room while half of it is taken. Otherwise a flooded robot could not record its grants, and the judge
        would blame the robot that drives by them.
"""

from collections import deque
from dataclasses import dataclass

from protocol.timeline import Entry, MessageRefused, Record
from protocol.wire.codec import SIZE_MAX_BYTES, packed
from protocol.wire.messages import BATCH_ENTRIES_MAX, LogBatch, Logged

BATCH_BYTES_MAX = SIZE_MAX_BYTES - 256  # the envelope takes less than 40 of the remaining bytes
RESEND_S = 0.3  # 100 times the delay of an acknowledgement on one machine
RESEND_S_PER_ROBOT = 0.004  # many robots wait for seconds: of 1,000, four in five batches came again
OUTBOX_CAPACITY = 10_000
OUTBOX_BYTES_MAX = 256 * SIZE_MAX_BYTES  # 16 MiB: an entry of a robot usually takes less than 1 kB


def resend_s(robots: int) -> float:
    """After how long an entry is sent again in a fleet of so many robots [wall s]."""
    return max(RESEND_S, RESEND_S_PER_ROBOT * robots)


@dataclass(slots=True)
class _Kept:
    """An entry that is not acknowledged yet."""

    entry: Entry
    size_bytes: int
    sent_s: float | None = None

    def send(self, now_s: float) -> None:
        """Mark it as sent."""
        self.sent_s = now_s


class Outbox:
    """Numbers entries and selects the next ones to send."""

    def __init__(
        self,
        incarnation: str = "",
        *,
        resend_s: float = RESEND_S,
        capacity: int = OUTBOX_CAPACITY,
        bytes_max: int = OUTBOX_BYTES_MAX,
    ) -> None:
        self.lost_count = 0
        self._incarnation = incarnation
        self._resend_s = resend_s
        self._capacity, self._bytes_max = capacity, bytes_max
        self._bytes = 0
        self._kept: deque[_Kept] = deque()
        self._newest = 0

    def __len__(self) -> int:
        """The number of entries that are not acknowledged yet."""
        return len(self._kept)

    def add(self, record: Record, *, t_s: float, hlc: str) -> None:
        """Add a new entry, to be sent and kept until it is acknowledged."""
        room = self._capacity // 2 if isinstance(record, MessageRefused) else self._capacity  # rule 5
        if len(self._kept) >= room:
            self.lost_count += 1
            return
        entry = Entry(n=self._newest + 1, t_s=t_s, hlc=hlc, record=record)
        size_bytes = len(packed(entry))
        assert size_bytes <= BATCH_BYTES_MAX, f"{type(record).__name__} takes {size_bytes} bytes"
        if self._bytes + size_bytes > self._bytes_max:
            self.lost_count += 1
            return
        self._newest = entry.n
        self._bytes += size_bytes
        self._kept.append(_Kept(entry, size_bytes))

    def batch(self, now_s: float) -> LogBatch | None:
        """The next entries to send, marked as sent; None if there are none. Call it until it returns None."""
        entries: list[Entry] = []
        room_bytes = BATCH_BYTES_MAX
        for kept in self._kept:
            if not entries and kept.sent_s is not None and now_s - kept.sent_s < self._resend_s:
                continue
            room_bytes -= kept.size_bytes
            if room_bytes < 0 or len(entries) == BATCH_ENTRIES_MAX:
                break
            kept.send(now_s)
            entries.append(kept.entry)
        return LogBatch(incarnation=self._incarnation, entries=tuple(entries)) if entries else None

    def acknowledged(self, logged: Logged) -> None:
        """Process an acknowledgement; entries that were never sent are kept."""
        if logged.incarnation != self._incarnation:
            return
        up_to = logged.up_to
        while self._kept and self._kept[0].entry.n <= up_to and self._kept[0].sent_s is not None:
            self._bytes -= self._kept.popleft().size_bytes
