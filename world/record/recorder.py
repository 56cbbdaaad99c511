"""The recorder: every entry of every source, once and in the source's order, into `events.jsonl`.

Rule 1: the file is unbuffered and an entry is one write, so a SIGKILL loses nothing that was written.
Rule 2: a source is written up to its first missing number; what lies beyond waits to be sent again.
Rule 3: an entry is acknowledged only after it has been written.
Rule 4: a source that is started again is a new incarnation and counts from 1. Once its first entry is
        written, nothing of its forerunners is any more: what they had not told, they take with them.
"""

from collections import Counter
from collections.abc import Sequence
from io import FileIO
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from protocol.errors import ClewError, UsageError
from protocol.files.writing import make_folder, open_private
from protocol.keys import WORLD
from protocol.timeline import Entry

SCHEMA = "clew-timeline/1"
EVENTS_FILE = "events.jsonl"


class RecordingFailedError(ClewError):
    """The timeline cannot be written any more: a run that leaves no record must not go on."""


class Header(Struct, frozen=True, kw_only=True, tag_field="kind", tag="run.started"):
    """The first line of a timeline: with it, a log can be judged by itself."""

    t_s: float = 0.0
    hlc: str = ""
    source: str = WORLD
    n: int = 0
    """The header is before the world's first entry, which has number 1."""
    schema: str = SCHEMA
    run: str
    seed: int
    speed: float | None
    """Simulated seconds per second; None: as fast as the robots answer."""
    started_at: str
    scenario: dict[str, Any]
    scenario_hash: str
    versions: dict[str, str]
    faults: dict[str, Any] | None = None
    """The fault plan; None: there was none, or the log is older than this field."""


class Recorder:
    """Writes one timeline and knows what it still lacks."""

    def __init__(self, file: FileIO, header: Header | None) -> None:
        """Begins the file with the header; None: the file has one, and `recall` says what else."""
        self._file = file
        self.recorded_count = 0
        """Entries written, of all sources."""
        self._written: Counter[tuple[str, str]] = Counter()
        self._newest: Counter[tuple[str, str]] = Counter()
        self._speaks: dict[str, str] = {}
        """The incarnation of each source whose entries are written."""
        self._gone: set[tuple[str, str]] = set()
        if header is not None:
            self._write(msgspec.json.encode(header) + b"\n")

    @property
    def missing(self) -> dict[str, int]:
        """How many entries each source is known to have made that are not written; none: it is not named."""
        short: Counter[str] = Counter()
        for (source, incarnation), newest in self._newest.items():
            if (source, incarnation) not in self._gone:
                short[source] += newest - self._written[source, incarnation]
        return dict(+short)

    def up_to(self, source: str, incarnation: str = "") -> int:
        """The number up to which all entries of a source are written: the acknowledgement."""
        return self._written[source, incarnation]

    def take(self, source: str, entries: Sequence[Entry], incarnation: str = "") -> list[Entry]:
        """Write what continues a source's entries; returns what was written.

        Raises:
            RecordingFailedError: the file cannot be written.
        """
        who = source, incarnation
        taken: list[Entry] = []
        for entry in entries if who not in self._gone else ():
            self._newest[who] = max(self._newest[who], entry.n)
            if entry.n == self._written[who] + 1:
                self._write(line(source, entry))
                self.recall(source, entry, incarnation)
                taken.append(entry)
        return taken

    def recall(self, source: str, entry: Entry, incarnation: str = "") -> None:
        """An entry stands in the file."""
        self._hand_over(source, incarnation)
        self._written[source, incarnation] = entry.n
        self._newest[source, incarnation] = max(self._newest[source, incarnation], entry.n)
        self.recorded_count += 1

    def _hand_over(self, source: str, incarnation: str) -> None:
        """Rule 4."""
        before = self._speaks.setdefault(source, incarnation)
        if before != incarnation:
            self._gone.add((source, before))
            self._speaks[source] = incarnation

    def _write(self, text: bytes) -> None:
        try:
            while text:  # a write to a full disk may be cut short before the next one fails
                text = text[self._file.write(text) :]
        except OSError as error:
            raise RecordingFailedError(f"cannot write {self._file.name!r}: {error.strerror}") from error


def line(source: str, entry: Entry) -> bytes:
    """An entry as the log has it: one flat object, the record's fields behind the entry's."""
    stamp = {"t_s": entry.t_s, "hlc": entry.hlc, "source": source, "n": entry.n}
    return msgspec.json.encode(stamp)[:-1] + b"," + msgspec.json.encode(entry.record)[1:] + b"\n"


def open_events(folder: Path) -> FileIO:
    """Make the run's folder and, in it, the timeline, which must not be there yet.

    Raises:
        UsageError: it cannot be made.
    """
    path = folder / EVENTS_FILE
    try:
        if not folder.is_dir():
            make_folder(folder)
        return open_private(path, "x")
    except OSError as error:
        if path.exists():
            raise UsageError(f"{path}: a run has been recorded there already") from error
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
