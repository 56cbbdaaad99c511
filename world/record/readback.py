"""Reads the timeline back as it stands in the file, and finds what was written and does not stand there.

Rule 1: the file is opened by its path, as any reader would: a folder that was removed or replaced shows.
Rule 2: every line is read once, soon after it was written. So the end of a run costs the same however long
        the run was.
Rule 3: the entries of a source have consecutive numbers, and a new process counts from 1. Numbers that are
        skipped are lost, and so is a line that cannot be read.
"""

import os
from collections import Counter
from collections.abc import Iterator, Mapping
from io import FileIO
from pathlib import Path

from protocol.errors import UNREADABLE
from protocol.files.opening import open_regular
from world.record.lines import Line, read_line
from world.record.recorder import EVENTS_FILE, RecordingFailedError

READ_BYTES = 1 << 16  # at a time: about 400 entries, which a live world reads and judges in 10 ms


class Readback:
    """Follows the timeline that a recorder writes."""

    def __init__(self, folder: Path, written: FileIO) -> None:
        """`written`: the file that the recorder writes.

        Raises:
            RecordingFailedError: the folder has another file, or none.
        """
        self.is_behind = True
        """Whether the file may have more than was read."""
        self._path = folder / EVENTS_FILE
        self._written = written
        self.check()
        self._file = open_regular(self._path)
        self._torn = b""
        self._is_begun = False
        """Whether the header has been read."""
        self._newest: dict[str, int] = {}
        self._skipped: Counter[str] = Counter()
        """The entries that are known to be missing, by source."""
        self._read: Counter[str] = Counter()

    @property
    def read_count(self) -> int:
        """The number of entries that stand in the file."""
        return self._read.total()

    def check(self) -> None:
        """Make sure that what is written still goes into the file of the run.

        Raises:
            RecordingFailedError: the file was removed, replaced or cut off.
        """
        try:
            found = self._path.stat()
        except OSError as error:
            raise self._failed("removed") from error
        ours = os.fstat(self._written.fileno())
        if (found.st_dev, found.st_ino) != (ours.st_dev, ours.st_ino):
            raise self._failed("replaced")
        if found.st_size < self._written.tell():
            raise self._failed("cut off")

    def _failed(self, how: str) -> RecordingFailedError:
        return RecordingFailedError(f"{self._path} was {how}: the run has no record any more, so it ends")

    def read(self) -> list[Line]:
        """The next entries in the file, about `READ_BYTES` of them at most."""
        text = self._file.read(READ_BYTES)
        self.is_behind = len(text) == READ_BYTES
        *whole, self._torn = (self._torn + text).split(b"\n")
        if whole and not self._is_begun:
            del whole[0]
            self._is_begun = True
        return list(self._lines(whole))

    def _lines(self, whole: list[bytes]) -> Iterator[Line]:
        for text in whole:
            try:
                source, entry = read_line(text)
            except UNREADABLE:
                continue  # its number is missing
            self._count(source, entry.n)
            yield source, entry

    def _count(self, source: str, n: int) -> None:
        """Rule 3."""
        newest = self._newest.get(source, 0)
        if n != 1:
            self._skipped[source] += n - newest - 1 if n > newest else 1
        self._newest[source] = n
        self._read[source] += 1

    def lost(self, written: Mapping[str, int]) -> int:
        """How many entries do not stand in the file, though they were written; so many were, by source."""
        return sum(
            max(self._skipped[source], written.get(source, 0) - self._read[source])
            for source in self._newest.keys() | written.keys()
        )

    def close(self) -> None:
        """Close the file."""
        self._file.close()
