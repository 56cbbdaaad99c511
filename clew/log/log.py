"""A run's log, line by line.

Rule 1: everything readable is read. Everything else is a flaw with its line, never an exception.
Rule 2: a log is complete if no source's numbers have a hole, and the world itself ended the run.
Rule 3: a log of another schema is read as far as this program knows its kinds and their fields.
"""

import re
from collections.abc import Iterator
from hashlib import blake2b
from io import BufferedReader, BytesIO
from pathlib import Path
from typing import Any

import msgspec

from clew.log.flaws import Findings
from clew.log.header import header_of, is_entry
from protocol.errors import UNREADABLE, UsageError
from protocol.files.opening import open_regular
from world.record.lines import Line, read_line, read_lines
from world.record.recorder import EVENTS_FILE
from world.scenario.fleets import FLEET_NAME

BLOCK_BYTES = 1 << 18  # read at once, to be decoded at once
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
            number = 1
            if not self._headless:
                _line(file)
                number = 2
            while block := _block(file):
                try:
                    lines = read_lines(block)
                except UNREADABLE:
                    yield from _one_by_one(block, number, findings, unread)
                else:
                    findings.hear(lines)
                    yield from lines
                number += block.count(b"\n")
        self.flaws, self.ended = tuple(findings.flaws(self.path.parent)), findings.ended
        self.unread = unread.digest()

    def _open(self) -> BufferedReader:
        try:
            return open_regular(self.path)
        except OSError as error:
            where = f"{self.path.parent}: {self.path.name}" if self._in_folder else str(self.path)
            if self._in_folder:
                check_one_fleet(self.path.parent)
            raise UsageError(f"no run in {where}: {error.strerror}") from error


def check_run_or_campaign(source: Path) -> None:
    """Refuse what is not there, and the folder of a run with several fleets.

    Raises:
        UsageError: it says which.
    """
    if not source.exists():
        raise UsageError(f"{source}: there is no such run or campaign")
    check_one_fleet(source)


def check_one_fleet(run: Path) -> None:
    """Refuse the folder of a run with several fleets, where one fleet is needed.

    Raises:
        UsageError: it names their folders.
    """
    if folders := ", ".join(str(run / name) for name in fleets_in(run)):
        raise UsageError(f"{run}: has several fleets, each with a folder: {folders}")


def fleets_in(run: Path) -> list[str]:
    """The names of the fleets of a run with several, which has a folder for each; otherwise none.

    A folder of runs, such as `runs/`, has other names in it, and a link.
    """
    if not run.is_dir() or (run / EVENTS_FILE).exists():
        return []
    folders = [each.parent for each in run.glob(f"*/{EVENTS_FILE}")]
    if any(each.is_symlink() or not re.fullmatch(FLEET_NAME, each.name) for each in folders):
        return []
    return sorted(each.name for each in folders)


def _one_by_one(block: bytes, first: int, findings: Findings, unread: "blake2b") -> Iterator[Line]:
    """The readable entries of lines, of which the first has this number in the file."""
    for number, text in enumerate(BytesIO(block), start=first):
        if text[-1:] != b"\n":
            unread.update(text)
            if len(text) < LINE_BYTES_MAX:
                findings.torn(number)
            else:
                findings.too_long(number, LINE_BYTES_MAX)
            continue
        try:
            line = read_line(text)
        except UNREADABLE as error:
            unread.update(_timeless(text))
            findings.misread(number, text, error)
        else:
            findings.hear((line,))
            yield line


def _timeless(text: bytes) -> bytes:
    """An unreadable line without its hybrid clock, if it has one."""
    try:
        fields = msgspec.json.decode(text, type=dict[str, Any])
    except UNREADABLE:
        return text
    fields.pop("hlc", None)
    return msgspec.json.encode(fields, order="sorted")


def _block(file: BufferedReader) -> bytes:
    """The next lines of a file, or nothing at its end; of a line that is too long only the first part."""
    text = file.read(min(BLOCK_BYTES, LINE_BYTES_MAX))
    return text if text[-1:] in {b"", b"\n"} else text + _line(file, len(text) - text.rfind(b"\n") - 1)


def _line(file: BufferedReader, had_bytes: int = 0) -> bytes:
    """The rest of a line, of which so much has been read; no more than its limit."""
    text = rest = file.readline(LINE_BYTES_MAX - had_bytes)
    while len(rest) + had_bytes == LINE_BYTES_MAX and rest[-1:] != b"\n":
        rest, had_bytes = file.readline(LINE_BYTES_MAX), 0
    return text
