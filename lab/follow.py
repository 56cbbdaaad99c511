"""Follows the timeline of a run that goes on: whole entries, each once, as they come. Only ever reads.

Rule 1: what stands before the file's last newline is whole and stays. What follows it is torn: it is read
        again until it is whole, because a world that resumes cuts it off and writes something else there.
Rule 2: whatever can be read is given; what cannot is a flaw with its line, and never an exception.
Rule 3: a run has ended when its verdict stands beside the timeline, or `run.ended` has been read and no
        verdict comes for `VERDICT_S`. A world that died for good ends nothing: then the caller has to.
"""

import asyncio
import itertools
from collections.abc import AsyncGenerator
from dataclasses import dataclass
from pathlib import Path

from lab.log import LINE_BYTES_MAX
from lab.log_header import UNREADABLE, read_header
from protocol.errors import UsageError
from protocol.timeline import Entry, RunEnded
from world.lines import read_line
from world.recorder import EVENTS_FILE, SCHEMA, Header
from world.verdict import VERDICT_FILE

LOOK_S = 0.1  # wall clock, between two looks at the file: as often as a table or a page is drawn
VERDICT_S = 10.0  # wall clock: the world judges a million entries in less
READ_BYTES = 1 << 20  # at once, so that a run that is followed late is shown in parts


@dataclass(frozen=True, slots=True)
class Heard:
    """An entry, its source, and the line that it was read from, without the newline."""

    text: bytes
    source: str
    entry: Entry


@dataclass(frozen=True, slots=True)
class News:
    """What one look at the file has brought."""

    header: Header | None
    """The run's, in the first news that brings lines; None in all others."""
    heard: tuple[Heard, ...]
    flaws: tuple[str, ...]


@dataclass(slots=True)
class Follower:
    """How much has been read. Pure: the caller reads the file, from `whole_bytes` on."""

    whole_bytes: int = 0
    torn_bytes: int = 0
    """How long the text is that stood behind the last newline."""
    ended: bool = False
    """Whether `run.ended` has been read."""
    _lines: int = 0

    @property
    def wanted_bytes(self) -> int:
        """How much to read: more than is torn, for a line may be longer than what is read at once."""
        return min(READ_BYTES + 2 * self.torn_bytes, LINE_BYTES_MAX)

    def take(self, text: bytes) -> News:
        """The news in what stands in the file from `whole_bytes` on."""
        *whole, torn = text.split(b"\n")
        self.whole_bytes += len(text) - len(torn)
        self.torn_bytes = len(torn)
        header, heard, flaws = None, list[Heard](), list[str]()
        for line in whole:
            self._lines += 1
            try:
                if self._lines == 1:
                    header = read_header(line, Path(EVENTS_FILE))
                    if header.schema != SCHEMA:
                        flaws.append(f"its schema is {header.schema!r}, this program reads {SCHEMA!r}")
                else:
                    source, entry = read_line(line)
                    heard.append(Heard(line, source, entry))
                    self.ended = self.ended or isinstance(entry.record, RunEnded)
            except (UsageError, *UNREADABLE) as error:
                flaws.append(f"line {self._lines} cannot be read: {error}")
        return News(header, tuple(heard), tuple(flaws))

    def miss(self, size_bytes: int) -> News:
        """The news that the file is shorter than what was read of it; what comes next is read."""
        gone_bytes, self.whole_bytes, self.torn_bytes = self.whole_bytes - size_bytes, size_bytes, 0
        return News(None, (), (f"{gone_bytes} bytes that had been read are no longer in the file",))

    def close(self) -> News:
        """The last news, of a run that has ended."""
        torn = (f"line {self._lines + 1} is torn: dropped",) if self.torn_bytes else ()
        return News(None, (), torn)


async def follow(run: Path) -> AsyncGenerator[News]:
    """What is new in a run's timeline, until the run has ended; waits for a run that is not there yet.

    Args:
        run: its folder, or its `events.jsonl`. A link like `runs/latest` is followed once, at the beginning.

    Raises:
        UsageError: it is there and cannot be read.
    """
    path, follower, patience = _timeline_of(run), Follower(), itertools.count()
    while True:
        # Before the look: what the world has recorded by then is seen.
        judged = path.with_name(VERDICT_FILE).exists()
        news = look(path, follower)
        if news.heard or news.header or news.flaws:
            yield news
        elif judged or (follower.ended and next(patience) * LOOK_S > VERDICT_S):
            break
        else:
            await asyncio.sleep(LOOK_S)
    if (last := follower.close()).flaws:
        yield last


def look(path: Path, follower: Follower) -> News:
    """What stands in the file now and has not been read; nothing, where there is no file.

    Raises:
        UsageError: it cannot be read.
    """
    try:
        size_bytes = path.stat().st_size
        if size_bytes < follower.whole_bytes:
            return follower.miss(size_bytes)
        with path.open("rb") as file:
            file.seek(follower.whole_bytes)
            return follower.take(file.read(follower.wanted_bytes))
    except FileNotFoundError:
        return News(None, (), ())
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error


def _timeline_of(run: Path) -> Path:
    is_file = run.is_file() or run.suffix == Path(EVENTS_FILE).suffix
    return (run if is_file else run / EVENTS_FILE).resolve()
