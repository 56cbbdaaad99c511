"""The timeline of a run in memory, and a choice of its entries. `log.Log` reads entry by entry instead."""

from dataclasses import dataclass
from fnmatch import filter as filter_names
from fnmatch import fnmatchcase
from pathlib import Path
from typing import get_args

from clew.log.log import Log
from protocol.files.names import did_you_mean
from protocol.keys import robot_name
from protocol.timeline import Entry, Record, RunEnded
from world.record.lines import Line
from world.record.recorder import Header

KINDS = tuple(each.__struct_config__.tag for each in get_args(Record))
NAMING = ("robot", "other", "to", "neighbour", "blocked", "before", "named", "coordinator", "about", "by")
"""The fields that name a robot."""


@dataclass(frozen=True, slots=True)
class Timeline:
    """A log in memory: entries in the recorder's order, and the flaws of the file."""

    header: Header
    lines: tuple[Line, ...]
    flaws: tuple[str, ...]

    @property
    def ended(self) -> str | None:
        """How the run ended; None: the world died before it could say so."""
        reasons = (entry.record.reason for _, entry in self.lines if isinstance(entry.record, RunEnded))
        return next(reasons, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """Which entries to show; None or empty: all."""

    source: tuple[str, ...] = ()
    kind: tuple[str, ...] = ()
    """Wildcards are allowed, as in `step.*`."""
    robot: int | None = None
    """Entries from this robot, or about it."""
    step: int | None = None
    rule: tuple[str, ...] = ()
    """Names of fault rules; wildcards are allowed. Only injections have one."""
    key: tuple[str, ...] = ()
    """Keys of messages, as `link/r2/*`. Only injections into messages and refusals have one."""
    from_s: float | None = None
    to_s: float | None = None

    def takes(self, source: str, entry: Entry) -> bool:
        """Whether an entry is chosen."""
        return (
            (not self.source or source in self.source)
            and (not self.kind or _matches(kind_of(entry.record), self.kind))
            and (self.robot is None or source == robot_name(self.robot) or names(entry.record, self.robot))
            and (self.step is None or getattr(entry.record, "step", None) == self.step)
            and (not self.rule or _matches(getattr(entry.record, "rule", None), self.rule))
            and (not self.key or _matches(getattr(entry.record, "key", None), self.key))
            and (self.from_s is None or entry.t_s >= self.from_s)
            and (self.to_s is None or entry.t_s <= self.to_s)
        )


def read(run: Path) -> Timeline:
    """Read a timeline into memory from the folder of a run, or from its `events.jsonl`.

    Raises:
        UsageError: there is no such run, or the first line is no header of ours.
    """
    log = Log(run)
    return Timeline(log.header, tuple(log.lines), log.flaws)


def unknown_kinds(patterns: tuple[str, ...]) -> str | None:
    """Say which of these patterns no kind matches, with similar names; None: each matches one."""
    unknown = [pattern for pattern in patterns if not filter_names(KINDS, pattern)]
    known = [*KINDS, *sorted({f"{kind.partition('.')[0]}.*" for kind in KINDS})]
    return "; ".join(f"there is no kind {each!r}{did_you_mean(each, known)}" for each in unknown) or None


def _matches(name: object, patterns: tuple[str, ...]) -> bool:
    return isinstance(name, str) and any(fnmatchcase(name, pattern) for pattern in patterns)


def kind_of(record: Record) -> str:
    """The kind of a record, as in the log."""
    kind = type(record).__struct_config__.tag
    assert isinstance(kind, str), record
    return kind


def names(record: Record, robot: int) -> bool:
    """Whether a record is about this robot, by one of its fields."""
    return getattr(record, "process", None) == robot_name(robot) or any(
        getattr(record, field, None) == robot for field in NAMING
    )
