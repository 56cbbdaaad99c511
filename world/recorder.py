"""The recorder: every entry of every source, once and in the source's order, into `events.jsonl`.

Rule 1: the file is unbuffered and an entry is one write, so a SIGKILL loses nothing that was written.
Rule 2: a source is written up to its first missing number; what lies beyond waits to be sent again.
Rule 3: an entry is acknowledged only after it has been written.
"""

from collections import defaultdict
from collections.abc import Sequence
from io import FileIO
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from protocol.errors import ClewError, UsageError
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


class Recorder:
    """Writes one timeline and knows what it still lacks."""

    def __init__(self, file: FileIO, header: Header) -> None:
        self._file = file
        self._written: defaultdict[str, int] = defaultdict(int)
        self._newest: defaultdict[str, int] = defaultdict(int)
        self._write(msgspec.json.encode(header) + b"\n")

    @property
    def recorded_count(self) -> int:
        """Entries written, of all sources."""
        return sum(self._written.values())

    @property
    def missing_count(self) -> int:
        """Entries that a source is known to have made and that are not written."""
        return sum(newest - self._written[source] for source, newest in self._newest.items())

    def up_to(self, source: str) -> int:
        """The number up to which all entries of a source are written: the acknowledgement."""
        return self._written[source]

    def take(self, source: str, entries: Sequence[Entry]) -> list[Entry]:
        """Write what continues a source's entries; returns what was written.

        Raises:
            RecordingFailedError: the file cannot be written.
        """
        taken: list[Entry] = []
        for entry in entries:
            self._newest[source] = max(self._newest[source], entry.n)
            if entry.n == self._written[source] + 1:
                self._write(line(source, entry))
                self._written[source] = entry.n
                taken.append(entry)
        return taken

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
        folder.mkdir(parents=True, exist_ok=True)
        return FileIO(str(path), "x")
    except OSError as error:
        if path.exists():
            raise UsageError(f"{path}: a run has been recorded there already") from error
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
