"""The timeline of a rehearsal: entries of all sources, numbered and stamped. No entry is lost."""

from collections import Counter

from protocol.timeline import Entry, Record

NTP64_PER_S = 2**32  # the unit of Zenoh's time stamps


class Logbook:
    """Entries in the order in which they were written."""

    def __init__(self) -> None:
        self.entries: list[tuple[str, Entry]] = []
        """Sources and their entries."""
        self._counts: Counter[str] = Counter()
        self._stamps: Counter[str] = Counter()

    def begin(self, source: str) -> None:
        """Count from 1 for a new process of the source."""
        self._counts[source] = 0

    def write(self, source: str, t_s: float, record: Record) -> Entry:
        """Add an entry. Time stamps of one source are unique, as with Zenoh's clock."""
        self._counts[source] += 1
        self._stamps[source] = max(self._stamps[source] + 1, int(t_s * NTP64_PER_S))
        hlc = f"{self._stamps[source]}/{source}"
        entry = Entry(n=self._counts[source], t_s=t_s, hlc=hlc, record=record)
        self.entries.append((source, entry))
        return entry
