"""A run's log, line by line.

Rule 1: everything readable is read. Everything else is a flaw with its line, never an exception.
Rule 2: a log is complete if no source's numbers have a hole, and the world itself ended the run.
Rule 3: a log of another schema is read as far as this program knows its kinds and their fields.
"""

from collections.abc import Iterator
from hashlib import blake2b
from io import BufferedReader
from pathlib import Path
from typing import Any

import msgspec

from clew.log.flaws import Findings
from clew.log.header import UNREADABLE, header_of, is_entry
from protocol.errors import UsageError
from protocol.files.opening import open_regular
from world.record.lines import Line, read_line
from world.record.recorder import EVENTS_FILE

LINE_BYTES_MAX = 1 << 25  # 32 MiB
"""Much more than any real entry: a line without an end must not fill the memory."""


class Log:
    """A log that is read line by line from its file each time, so that a million entries take no memory.

    When all lines have been read, `flaws` and `ended` are those of `Timeline`, and `unread` is a hash of the
    unreadable lines without their clocks.
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
        self.unread = b""

    @property
    def lines(self) -> Iterator[Line]:
        """The readable entries with their sources, in the recorder's order."""
        findings, unread = Findings(self.header, self._damage), blake2b()
        with self._open() as file:
            for number, text in enumerate(_texts(file), start=1):
                if number == 1 and not self._headless:
                    continue
                if text[-1:] != b"\n":
                    unread.update(text)
                    if len(text) < LINE_BYTES_MAX:
                        findings.torn(number)
                    else:
                        findings.too_long(number, LINE_BYTES_MAX)
                    continue
                try:
                    source, entry = read_line(text)
                except UNREADABLE as error:
                    unread.update(_timeless(text))
                    findings.misread(number, text, error)
                else:
                    findings.hear(source, entry)
                    yield source, entry
        self.flaws, self.ended = tuple(findings.flaws(self.path.parent)), findings.ended
        self.unread = unread.digest()

    def _open(self) -> BufferedReader:
        try:
            return open_regular(self.path)
        except OSError as error:
            where = f"{self.path.parent}: {self.path.name}" if self._in_folder else str(self.path)
            raise UsageError(f"no run in {where}: {error.strerror}") from error


def _timeless(text: bytes) -> bytes:
    """An unreadable line without its hybrid clock, if it has one."""
    try:
        fields = msgspec.json.decode(text, type=dict[str, Any])
    except UNREADABLE:
        return text
    fields.pop("hlc", None)
    return msgspec.json.encode(fields, order="sorted")


def _texts(file: BufferedReader) -> Iterator[bytes]:
    """The lines of a file; of a line that is too long only the first part."""
    while text := file.readline(LINE_BYTES_MAX):
        yield text
        while len(text) == LINE_BYTES_MAX and not text.endswith(b"\n"):
            text = file.readline(LINE_BYTES_MAX)
