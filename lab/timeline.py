"""Reads the timeline of a run: `events.jsonl`, a header and then one entry a line.

Rule 1: whatever can be read is read; what cannot is a flaw, with its line, and never an exception.
Rule 2: a log is complete when no source's numbers have a hole and the world has ended the run itself. A robot
        that was started again begins with `robot.started`, counts from 1, and does not know the time yet.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import msgspec

from protocol.errors import UsageError
from protocol.keys import robot_name
from protocol.timeline import Entry, Record, RobotStarted, RunEnded
from world.lines import Line, read_line
from world.recorder import EVENTS_FILE, SCHEMA, Header


@dataclass(frozen=True, slots=True)
class Timeline:
    """A log as read: entries in the recorder's order, and what is wrong with the file."""

    header: Header
    lines: tuple[Line, ...]
    flaws: tuple[str, ...]

    @property
    def ended(self) -> str | None:
        """How the run ended; None where the world did not live to say so."""
        reasons = (entry.record.reason for _, entry in self.lines if isinstance(entry.record, RunEnded))
        return next(reasons, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Which lines to show; None, or naming nothing, chooses all."""

    source: tuple[str, ...] = ()
    kind: tuple[str, ...] = ()
    """May hold wildcards, as `step.*`."""
    robot: int | None = None
    """Entries from this robot, or that name it."""
    step: int | None = None
    from_s: float | None = None
    to_s: float | None = None

    def takes(self, source: str, entry: Entry) -> bool:
        """Whether a line is among the chosen."""
        return (
            (not self.source or source in self.source)
            and (not self.kind or any(fnmatchcase(kind_of(entry.record), kind) for kind in self.kind))
            and (self.robot is None or source == robot_name(self.robot) or names(entry.record, self.robot))
            and (self.step is None or getattr(entry.record, "step", None) == self.step)
            and (self.from_s is None or entry.t_s >= self.from_s)
            and (self.to_s is None or entry.t_s <= self.to_s)
        )


def read(run: Path) -> Timeline:
    """The timeline of a run, given its folder or its `events.jsonl`.

    Raises:
        UsageError: there is no such run, or its first line is no header of ours.
    """
    path = run / EVENTS_FILE if run.is_dir() else run
    try:
        first, *rest = path.read_bytes().split(b"\n")
    except OSError as error:
        raise UsageError(f"no run in {run}: {path.name}: {error.strerror}") from error
    try:
        header = msgspec.json.decode(first, type=Header)
    except (msgspec.MsgspecError, ValueError) as error:
        raise UsageError(f"{path}: the first line is no header of a run: {error}") from error
    if header.schema != SCHEMA:
        raise UsageError(f"{path}: its schema is {header.schema!r}, this program reads {SCHEMA!r}")
    lines, flaws = parse(rest)
    return Timeline(header, tuple(lines), (*flaws, *incompleteness(lines)))


def parse(rest: list[bytes]) -> tuple[list[Line], list[str]]:
    """The lines behind the header, and the flaws among them; what follows the last newline counts as torn."""
    lines: list[Line] = []
    flaws: list[str] = []
    for number, text in enumerate(rest, start=2):
        if number == len(rest) + 1:
            if text:
                flaws.append(f"line {number} is torn: dropped")
            break
        try:
            lines.append(read_line(text))
        except (msgspec.MsgspecError, ValueError) as error:
            flaws.append(f"line {number} cannot be read: {error}")
    return lines, flaws


def incompleteness(lines: Iterable[Line]) -> Iterator[str]:
    """What the numbers say is missing or too much, source by source."""
    numbers: defaultdict[tuple[str, int], Counter[int]] = defaultdict(Counter)
    lives: Counter[str] = Counter()
    began: dict[str, Entry] = {}
    last: dict[str, Entry] = {}
    ended = False
    for source, entry in lines:
        if entry.n == 1 and isinstance(entry.record, RobotStarted) and began.get(source) != entry:
            lives[source] += 1
            began[source] = last[source] = entry
        numbers[source, lives[source]][entry.n] += 1
        before = last.setdefault(source, entry)
        if entry.n < before.n or entry.t_s < before.t_s:
            yield f"{source}: entry {entry.n} of t={entry.t_s} s stands behind {before.n} of t={before.t_s} s"
        last[source] = entry
        ended = ended or isinstance(entry.record, RunEnded)
    for (source, _), seen in sorted(numbers.items()):
        if holes := [n for n in range(1, max(seen) + 1) if n not in seen]:
            yield f"{source}: {len(holes)} of {max(seen)} entries are missing, the first is number {holes[0]}"
        if twice := [n for n, times in seen.items() if times > 1]:
            yield f"{source}: entry number {twice[0]} stands in the log more than once"
    if not ended:
        yield "no run.ended: the world did not live to end the run"


def kind_of(record: Record) -> str:
    """The kind by which the log calls a record."""
    kind = type(record).__struct_config__.tag
    assert isinstance(kind, str), record
    return kind


def names(record: Record, robot: int) -> bool:
    """Whether a record says something of a robot other than the one that wrote it."""
    return any(getattr(record, field, None) == robot for field in ("robot", "other", "to", "neighbour"))
