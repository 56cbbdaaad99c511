"""The timeline of a run in memory, and which of its entries to show; `log.Log` reads one entry by entry."""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from clew.log.log import Log
from protocol.keys import robot_name
from protocol.timeline import Entry, Record, RunEnded
from world.record.lines import Line
from world.record.recorder import Header


@dataclass(frozen=True, slots=True)
class Timeline:
    """A log in memory: entries in the recorder's order, and what is wrong with the file."""

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
    """The timeline of a run in memory, given its folder or its `events.jsonl`; `Log` needs none.

    Raises:
        UsageError: there is no such run, or its first line is no header of ours.
    """
    log = Log(run)
    return Timeline(log.header, tuple(log.lines), log.flaws)


def kind_of(record: Record) -> str:
    """The kind by which the log calls a record."""
    kind = type(record).__struct_config__.tag
    assert isinstance(kind, str), record
    return kind


def names(record: Record, robot: int) -> bool:
    """Whether a record says something of a robot other than the one that wrote it."""
    return getattr(record, "process", None) == robot_name(robot) or any(
        getattr(record, field, None) == robot
        for field in ("robot", "other", "to", "neighbour", "blocked", "before")
    )
