"""Follows the timeline of a running fleet: gives each entry once, when it is complete. It never writes.

Rule 1: text before the last newline of the file is complete and stays. Text after it is torn and is read
        again until it is complete: a world that resumes cuts it off and writes something else there.
Rule 2: everything readable is given. Everything else is a flaw with its line, never an exception.
Rule 3: a run is over when its verdict is there, or when nobody writes any more (`clew/log/vigil.py`).
Rule 4: the flaws of a run that is over are those of `clew/log/log.py`, in the same words.
"""

import asyncio
from collections.abc import AsyncGenerator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from clew.log.flaws import Findings
from clew.log.header import header_or_rest, is_entry
from clew.log.log import LINE_BYTES_MAX
from clew.log.vigil import Vigil
from protocol.errors import UNREADABLE, UsageError
from protocol.files.opening import open_regular
from world.judge.verdict import VERDICT_FILE
from world.record.lines import Line, read_line, read_lines
from world.record.recorder import EVENTS_FILE, Header

LOOK_S = 0.1  # wall clock, between two reads of the file: about as often as a table or a page is drawn
READ_BYTES = 1 << 20  # at a time, so that a long run is shown in parts


@dataclass(frozen=True, slots=True)
class News:
    """What is new since the last read of the file."""

    header: Header | None
    """In the first news with lines; None in all others."""
    lines: Sequence[Line]
    """The new entries, with their sources."""
    flaws: tuple[str, ...]
    """Each is given once; of many of a kind the first ones, and the last news counts the rest."""

    def __bool__(self) -> bool:
        """Whether anything is new."""
        return bool(self.header or self.lines or self.flaws)


@dataclass(slots=True)
class Follower:
    """How much has been read of a file. Pure: the caller reads the file from `whole_bytes` on."""

    path: Path
    whole_bytes: int = 0
    torn_bytes: int = 0
    """Length of the text after the last newline."""
    _lines: int = 0
    _skips: bool = False
    """Whether we are inside a line that is too long."""
    _findings: Findings | None = None
    """None: the first line has not been read."""
    _flaws_told: int = 0

    @property
    def ended(self) -> bool:
        """Whether `run.ended` has been read."""
        return self._findings is not None and self._findings.ended is not None

    @property
    def wanted_bytes(self) -> int:
        """How much to read: more than the torn text, because a line may be longer than READ_BYTES."""
        return min(READ_BYTES + 2 * self.torn_bytes, LINE_BYTES_MAX)

    def take(self, text: bytes) -> News:
        """The news in the text of the file from `whole_bytes` on."""
        end = text.rfind(b"\n") + 1
        whole, torn = text[:end], text[end:]
        if self._skips:
            # Drop the rest of the long line: up to its newline, or all of the text.
            torn = torn if whole else b""
            self._skips, whole = not whole, whole.partition(b"\n")[2]
        before = self._findings
        lines = self._read(whole)
        if len(torn) >= LINE_BYTES_MAX:
            self._lines += 1
            self._begun(torn).too_long(self._lines, LINE_BYTES_MAX)
            self._skips, torn = True, b""
        self.whole_bytes += len(text) - len(torn)
        self.torn_bytes = len(torn)
        header = self._findings.header if self._findings is not None and before is None else None
        return News(header, lines, self._fresh_flaws())

    def _read(self, text: bytes) -> list[Line]:
        """The entries in whole lines."""
        if not text:
            return []
        first, _, rest = text.partition(b"\n")
        findings = self._begun(first)
        if self._lines == 0 and not is_entry(first):
            self._lines, text = 1, rest
        try:
            lines = read_lines(text)
        except UNREADABLE:
            return list(self._one_by_one(text, findings))
        findings.hear(lines)
        self._lines += len(lines)
        return lines

    def _one_by_one(self, whole: bytes, findings: Findings) -> Iterator[Line]:
        for text in whole.split(b"\n")[:-1]:
            self._lines += 1
            try:
                line = read_line(text)
            except UNREADABLE as error:
                findings.misread(self._lines, text, error)
            else:
                findings.hear((line,))
                yield line

    def _begun(self, line: bytes) -> Findings:
        """The findings; they begin with the first line."""
        if self._findings is None:
            header, damage = header_or_rest(line, self.path)
            self._findings = Findings(header, damage)
        return self._findings

    def _fresh_flaws(self) -> tuple[str, ...]:
        """Flaws that stay and were not given yet."""
        certain = () if self._findings is None else tuple(self._findings.at_once())
        fresh, self._flaws_told = certain[self._flaws_told :], len(certain)
        return fresh

    def miss(self, size_bytes: int) -> News:
        """The file is shorter than what was read of it: say so, and read on from its end."""
        gone_bytes, self.whole_bytes, self.torn_bytes = self.whole_bytes - size_bytes, size_bytes, 0
        self._skips = False
        return News(None, (), (f"{gone_bytes} bytes that had been read are no longer in the file",))

    def close(self) -> News:
        """The last news of a run that is over: the remaining flaws."""
        if self._findings is None:
            what = "the first line is torn" if self.torn_bytes else "it is empty"
            return News(None, (), (f"{self.path}: {what}: no header of a run",))
        if self.torn_bytes:
            self._findings.torn(self._lines + 1)
        flaws = tuple(self._findings.flaws(self.path.parent))
        return News(None, (), flaws[self._flaws_told :])


async def follow(run: Path) -> AsyncGenerator[News]:
    """The news in a run's timeline until the run is over. Waits for a run that has not started yet.

    Args:
        run: its folder, or its `events.jsonl`. A link such as `runs/latest` is resolved once, at the start.

    Raises:
        UsageError: the timeline is there but cannot be read.
    """
    path = _timeline_of(run)
    follower, vigil = Follower(path), Vigil(path)
    while True:
        # Ask before the read, so that nothing recorded before the end is missed.
        is_over = path.with_name(VERDICT_FILE).exists() or vigil.is_over(ended=follower.ended)
        news = look(follower)
        if news:
            yield news
        elif is_over:
            break
        else:
            await asyncio.sleep(LOOK_S)
    if (last := follower.close()).flaws:
        yield last


def look(follower: Follower) -> News:
    """Read what is new in the follower's file; nothing, if there is no file.

    Raises:
        UsageError: it cannot be read.
    """
    try:
        size_bytes = follower.path.stat().st_size
        if size_bytes < follower.whole_bytes:
            return follower.miss(size_bytes)
        with open_regular(follower.path) as file:
            while True:
                wanted_bytes = follower.wanted_bytes
                file.seek(follower.whole_bytes)
                text = file.read(wanted_bytes)
                # No news from a full read: a line is longer than that, so read more.
                if (news := follower.take(text)) or len(text) < wanted_bytes:
                    return news
    except FileNotFoundError:
        return News(None, (), ())
    except OSError as error:
        raise UsageError(f"{follower.path}: cannot be read: {error.strerror}") from error


def _timeline_of(run: Path) -> Path:
    is_file = run.is_file() or run.suffix == Path(EVENTS_FILE).suffix
    return (run if is_file else run / EVENTS_FILE).resolve()
