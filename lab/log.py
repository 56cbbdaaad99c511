"""A run's log, line by line.

Rule 1: whatever can be read is read; what cannot is a flaw, with its line, and never an exception.
Rule 2: a log is complete when no source's numbers have a hole and the world has ended the run itself.
Rule 3: a log of another schema is read as far as this program knows its kinds and their fields.
"""

from collections import Counter
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import get_args

import msgspec

from lab.completeness import Completeness, Told
from lab.log_header import UNREADABLE, Stamped, header_of, is_entry, other
from protocol.errors import UsageError
from protocol.mischief import goes_on
from protocol.timeline import Record, RunEnded
from world.lines import Line, read_line
from world.recorder import EVENTS_FILE, SCHEMA, Header

LINE_BYTES_MAX = 1 << 25  # 32 MiB
"""Far more than any real entry has: a line without an end must not fill the memory."""
KINDS = frozenset(each.__struct_config__.tag for each in get_args(Record))
"""All kinds that this program knows."""


class Log:
    """A log that is read line by line, anew each time: a million entries take no memory.

    `flaws` and `ended` say what `Timeline`'s do, once the lines have been gone through to the end.
    """

    def __init__(self, run: Path) -> None:
        self._in_folder = run.is_dir()
        self.path = run / EVENTS_FILE if self._in_folder else run
        with self._open() as file:
            first, second = file.readline(LINE_BYTES_MAX), file.readline(LINE_BYTES_MAX)
        self.header, self._damage = header_of(first, second, self.path)
        self._headless = is_entry(first)
        self.flaws: tuple[str, ...] = ()
        self.ended: str | None = None

    @property
    def lines(self) -> Iterator[Line]:
        """The entries that can be read, with their sources, in the recorder's order."""
        findings = _Findings(self.header, self._damage)
        with self._open() as file:
            for number, text in enumerate(_texts(file), start=1):
                if number == 1 and not self._headless:
                    continue
                try:
                    source, entry = read_line(text if text[-1:] == b"\n" else b"")
                except UNREADABLE as error:
                    findings.misread(number, text, error)
                else:
                    findings.completeness.hear(source, entry)
                    if isinstance(entry.record, RunEnded) and findings.ended is None:
                        findings.ended = entry.record.reason
                    yield source, entry
        self.flaws, self.ended = tuple(findings.flaws(self.path.parent)), findings.ended

    def _open(self) -> BufferedReader:
        try:
            return self.path.open("rb")
        except OSError as error:
            where = f"{self.path.parent}: {self.path.name}" if self._in_folder else str(self.path)
            raise UsageError(f"no run in {where}: {error.strerror}") from error


class _Findings:
    """What is found wrong with a log while it is read."""

    def __init__(self, header: Header, damage: str | None) -> None:
        self._header, self._damage = header, damage
        self._misread = Told()
        self._unknown: Counter[str] = Counter()
        self.completeness = Completeness()
        self.ended: str | None = None

    def misread(self, number: int, text: bytes, error: Exception) -> None:
        """A line is no entry that this program knows; its number in its source may still be read."""
        if not text.endswith(b"\n"):
            torn = len(text) < LINE_BYTES_MAX
            why = "is torn: dropped" if torn else f"is longer than {LINE_BYTES_MAX} bytes: dropped"
            self._misread.add(f"line {number} {why}")
            return
        try:
            line = msgspec.json.decode(text, type=Stamped)
        except UNREADABLE:
            self._misread.add(f"line {number} cannot be read: {error}")
            return
        self.completeness.number(line.source, line.n, line.t_s)
        if line.kind in KINDS:
            self._misread.add(f"line {number} cannot be read: {error}")
        else:
            self._unknown[line.kind] += 1

    def flaws(self, run: Path) -> Iterator[str]:
        """All of it, in sentences; `run` is the folder in which the log stands."""
        if self._damage is not None:
            yield self._damage
        elif self._header.schema != SCHEMA:
            yield f"{other(self._header.schema)}: only what both know can be shown"
        yield from self._misread
        unknown = Told()
        for kind, count in self._unknown.items():
            unknown.add(f"{count} entries of a kind that this program does not know: {kind!r}")
        yield from unknown
        yield from self.completeness.flaws()
        if self.ended is None and goes_on(run):
            yield "the run is still going on: this is what was recorded up to now"
        elif self.ended is None:
            yield "no run.ended: the world did not live to end the run"


def _texts(file: BufferedReader) -> Iterator[bytes]:
    """A file line by line; of a line that is too long, only as much as says so."""
    while text := file.readline(LINE_BYTES_MAX):
        yield text
        while len(text) == LINE_BYTES_MAX and not text.endswith(b"\n"):
            text = file.readline(LINE_BYTES_MAX)
