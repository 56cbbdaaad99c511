"""The recorder: writes each entry of each source once, in the source's order, into `events.jsonl`.

Rule 1: the file is unbuffered, and entries that come together are one write. So a SIGKILL loses nothing that
        was written, and nobody acts on an entry before it is.
Rule 2: a source is written up to its first missing number; later entries have to be sent again.
Rule 3: an entry is acknowledged only after it has been written.
Rule 4: a fence of a live world is on the disk before anyone is told of it, so it never goes back, also after
        a power cut (F3 of docs/strand.md). All else that such a cut may lose is no matter of safety.
Rule 5: a restarted source is a new incarnation and counts from 1. Once its first entry is written, entries of
        earlier incarnations are no longer accepted: what they had not sent is lost.
Rule 6: one world writes a timeline. Two would be two registers of one fence.
"""

import fcntl
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from protocol.errors import ClewError, UsageError
from protocol.files.writing import make_folder, open_private, sync_folder
from protocol.keys import WORLD
from protocol.timeline import Entry, FenceChanged

SCHEMA = "clew-timeline/1"
EVENTS_FILE = "events.jsonl"


class RecordingFailedError(ClewError):
    """The timeline can no longer be written: a run without a record must not continue."""


@contextmanager
def must_write(path: Path) -> Iterator[None]:
    """What writes a file without which a run must not continue.

    Raises:
        RecordingFailedError: it cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise RecordingFailedError(f"cannot write {path}: {error.strerror}") from error


class Header(Struct, frozen=True, kw_only=True, tag_field="kind", tag="run.started"):
    """The first line of a timeline: it makes the log complete enough to be judged alone."""

    t_s: float = 0.0
    hlc: str = ""
    source: str = WORLD
    n: int = 0
    """The header precedes the world's first entry, which has number 1."""
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
    """The fault plan; None: there was no plan, or the log is older than this field."""


class Written:
    """Which entries are in a timeline, and which are known to be missing."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        """The number of entries, by source."""
        self._written: Counter[tuple[str, str]] = Counter()
        """The newest entry, by source and incarnation."""
        self._newest: Counter[tuple[str, str]] = Counter()
        self._speaks: dict[str, str] = {}
        """The incarnation of each source that is being written."""
        self._gone: set[tuple[str, str]] = set()

    @property
    def missing(self) -> dict[str, int]:
        """By source: the number of entries that are known to exist and are not written; only if above 0."""
        short: Counter[str] = Counter()
        for (source, incarnation), newest in self._newest.items():
            if (source, incarnation) not in self._gone:
                short[source] += newest - self._written[source, incarnation]
        return dict(+short)

    def up_to(self, source: str, incarnation: str = "") -> int:
        """All entries of a source up to this number are there."""
        return self._written[source, incarnation]

    def follows(self, source: str, n: int, incarnation: str) -> bool:
        """Whether an entry is to be written next; it is known to exist from now on."""
        key = source, incarnation
        if key in self._gone:
            return False
        self._newest[key] = max(self._newest[key], n)
        return n == self._written[key] + 1

    def recall(self, source: str, incarnation: str, entry: Entry) -> None:
        """An entry is in the file."""
        before = self._speaks.setdefault(source, incarnation)
        if before != incarnation:  # rule 5
            self._gone.add((source, before))
            self._speaks[source] = incarnation
        key = source, incarnation
        self._written[key] = entry.n
        self._newest[key] = max(self._newest[key], entry.n)
        self.counts[source] += 1


class Recorder:
    """Writes one timeline, and knows which entries are missing."""

    def __init__(
        self, file: FileIO, header: Header | None, past: Written | None = None, *, syncs: bool = True
    ) -> None:
        """Begin the file with the header; None: the file has one, and the entries of `past`.

        `syncs`: fences survive a power cut (rule 4); nobody resumes a rehearsal.
        """
        self._file = file
        self._known = Written() if past is None else past
        self._syncs = syncs
        if header is not None:
            self._write(msgspec.json.encode(header) + b"\n")
            if syncs:
                self._sync(its_name=True)

    @property
    def written(self) -> Counter[str]:
        """The number of entries written, by source."""
        return self._known.counts

    @property
    def recorded_count(self) -> int:
        """The number of entries written, of all sources."""
        return self.written.total()

    @property
    def missing(self) -> dict[str, int]:
        """By source: the number of entries that are known to exist and are not written; only if above 0."""
        return self._known.missing

    def up_to(self, source: str, incarnation: str = "") -> int:
        """Acknowledgement: all entries of a source up to this number are written."""
        return self._known.up_to(source, incarnation)

    def take(self, source: str, entries: Sequence[Entry], incarnation: str = "") -> list[Entry]:
        """Write the entries that continue a source; returns the written ones.

        Raises:
            RecordingFailedError: the file cannot be written.
        """
        taken: list[Entry] = []
        for entry in entries:
            if self._known.follows(source, entry.n, incarnation):
                self._known.recall(source, incarnation, entry)
                taken.append(entry)
        if taken:
            self._write(b"".join(line(source, entry) for entry in taken))
        if self._syncs and source == WORLD and any(isinstance(each.record, FenceChanged) for each in taken):
            self._sync()
        return taken

    def _write(self, text: bytes) -> None:
        try:
            while text:  # on a full disk a write may be partial before the next one fails
                text = text[self._file.write(text) :]
        except OSError as error:
            raise RecordingFailedError(f"cannot write {self._file.name!r}: {error.strerror}") from error

    def _sync(self, *, its_name: bool = False) -> None:
        """Rule 4: it takes 0.3 ms (docs/measured.md)."""
        try:
            if its_name:
                sync_folder(Path(os.fsdecode(self._file.name)).parent)
            else:
                os.fdatasync(self._file.fileno())
        except OSError as error:
            raise RecordingFailedError(f"cannot sync {self._file.name!r}: {error.strerror}") from error


def line(source: str, entry: Entry) -> bytes:
    """An entry as a line of the log: one flat object, the entry's fields before the record's."""
    stamp = {"t_s": entry.t_s, "hlc": entry.hlc, "source": source, "n": entry.n}
    return msgspec.json.encode(stamp)[:-1] + b"," + msgspec.json.encode(entry.record)[1:] + b"\n"


def open_events(folder: Path) -> FileIO:
    """Create the run's folder and the timeline in it, which must not exist yet.

    Raises:
        UsageError: it cannot be created.
    """
    path = folder / EVENTS_FILE
    try:
        if not folder.is_dir():
            make_folder(folder)
        return held_alone(open_private(path, "x"))
    except OSError as error:
        if path.exists():
            raise UsageError(f"{path}: a run has been recorded there already") from error
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error


def held_alone(file: FileIO) -> FileIO:
    """Keep other worlds from writing this file as long as this process has it open (rule 6).

    Raises:
        BlockingIOError: another world writes it.
    """
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise
    except OSError:  # a file system without locks
        pass
    return file
