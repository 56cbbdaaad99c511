"""The flaws of a log, found while its lines are read: all of them at once, or while the file grows.

Rule 1: `TOLD_MAX` flaws of a kind are listed, the rest is counted: a log may have a million bad lines.
Rule 2: the flaws of `at_once` come first, in the same order, in the flaws at the end.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from clew.log.completeness import Completeness, Told
from clew.log.header import Stamped, other
from protocol.errors import UNREADABLE
from protocol.faults.manual_faults import is_running
from protocol.timeline import KINDS, RunEnded
from world.record.lines import Line
from world.record.recorder import SCHEMA, Header

STILL_GOING_ON = "the run is still going on: this is what was recorded up to now"


class Findings:
    """The flaws of a log, as far as it has been read."""

    def __init__(self, header: Header, damage: str | None) -> None:
        """Begin a log with this header, and with the damage of its first line, if any."""
        self.header, self._damage = header, damage
        self._misread = Told()
        self._unknown: Counter[str] = Counter()
        self._completeness = Completeness()
        self.ended: str | None = None
        """How the run ended; None: the log has not said so yet."""

    def hear(self, lines: Iterable[Line]) -> None:
        """The next lines are these entries."""
        hear = self._completeness.hear
        for source, entry in lines:
            hear(source, entry)
            if type(entry.record) is RunEnded and self.ended is None:
                self.ended = entry.record.reason

    def torn(self, number: int) -> None:
        """A line has no end."""
        self._misread.add(f"line {number} is torn: dropped")

    def too_long(self, number: int, bytes_max: int) -> None:
        """A line is longer than the limit."""
        self._misread.add(f"line {number} is longer than {bytes_max} bytes: dropped")

    def misread(self, number: int, text: bytes, error: Exception) -> None:
        """A line is no entry that this program knows; perhaps its source and number can be read."""
        try:
            line = msgspec.json.decode(text, type=Stamped)
        except UNREADABLE:
            self._misread.add(f"line {number} cannot be read: {error}")
            return
        self._completeness.number(line.source, line.n, line.t_s)
        if line.kind in KINDS:
            self._misread.add(f"line {number} cannot be read: {error}")
        else:
            self._unknown[line.kind] += 1

    def at_once(self) -> Iterator[str]:
        """Flaws that stay, however the log goes on."""
        if self._damage is not None:
            yield self._damage
        elif self.header.schema != SCHEMA:
            yield f"{other(self.header.schema)}: only what both know is shown"
        yield from self._misread.first

    def flaws(self, run: Path) -> Iterator[str]:
        """All flaws; `run` is the folder of the log."""
        yield from self.at_once()
        yield from self._misread.more
        unknown = Told()
        for kind, count in self._unknown.items():
            unknown.add(f"{count} entries of a kind that this program does not know: {kind!r}")
        yield from unknown
        yield from self._completeness.flaws()
        if self.ended is None and is_running(run):
            yield STILL_GOING_ON
        elif self.ended is None:
            yield "no run.ended: the world died before it could end the run"
