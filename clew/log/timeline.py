"""The timeline of a run in memory, and a choice of its entries. `log.Log` reads entry by entry instead."""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from fnmatch import filter as filter_names
from fnmatch import fnmatchcase
from operator import index
from pathlib import Path
from typing import SupportsIndex, TypeGuard

from clew.log.header import robots_of
from clew.log.log import Log
from protocol.files.names import did_you_mean
from protocol.keys import WORLD, keys_of, not_of_fleet, robot_name
from protocol.timeline import KINDS, Entry, FaultInjected, Record, RunEnded, kind_of
from world.faults import is_given
from world.record.lines import Line
from world.record.recorder import Header

NAMING = ("robot", "other", "to", "neighbour", "blocked", "before", "named", "coordinator", "about", "by")
"""The fields that name a robot."""
SHOWN = 10  # of the rules of a plan, which may have 1000
KEYED_ROBOTS_MAX = 100  # the keys of links grow with the square of the fleet; larger fleets are not checked


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
            and (not self.key or _matches(_key_of(entry.record), self.key))
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


def is_integer(value: object) -> TypeGuard[SupportsIndex]:
    """Whether a value is an integer, such as one of numpy; no boolean."""
    return hasattr(value, "__index__") and not isinstance(value, bool)


def unknown_step(step: object) -> str | None:
    """Say that this is no number of a switching step; None: it is one, or none is asked for.

    A text would be equal to no number, so no entry would match.
    """
    if step is None or (is_integer(step) and index(step) >= 0):
        return None
    return f"step: must be an integer, 0 or more, got {step!r}"


def unknown_wait(timeout_s: object) -> str | None:
    """Say that nobody can wait so long; None: it is a number of seconds, 0 or more, or infinite."""
    try:
        if float(timeout_s) >= 0.0:  # type: ignore[arg-type] # it raises for what is none
            return None
    except (TypeError, ValueError):
        pass
    return f"timeout_s: must be >= 0 [simulated s], got {timeout_s!r}"


def unknown_in(choice: Choice, header: Header, lines: Iterable[Line]) -> str | None:
    """Say what of a choice no entry of this run can have, with similar names; None: each may have one.

    A rule may be one of the plan, one that has struck, or one that was given by hand and has not struck.
    """
    return "; ".join(_unknown_in(choice, header, lines)) or None


def _unknown_in(choice: Choice, header: Header, lines: Iterable[Line]) -> Iterator[str]:
    robots = robots_of(header)
    sources = {WORLD, *map(robot_name, range(1, robots + 1))}
    if (unknown := unknown_kinds(choice.kind)) is not None:
        yield unknown
    for source in choice.source:
        if source not in sources:
            yield f"source: must be world, or {not_of_fleet(source, robots).removeprefix('must be ')}"
    if choice.robot is not None and choice.robot not in range(1, robots + 1):
        yield f"robot: {not_of_fleet(choice.robot, robots)}"
    if (unknown := unknown_step(choice.step)) is not None:
        yield unknown
    if choice.rule or choice.key:
        records = [entry.record for _, entry in lines]  # read once: both look through them
        yield from _unknown_rules(choice.rule, header, records)
        if robots <= KEYED_ROBOTS_MAX:
            yield from _unknown_keys(choice.key, robots, records)
    if choice.from_s is not None and choice.to_s is not None and choice.from_s > choice.to_s:
        yield f"time: must be from an earlier time to a later one, got {choice.from_s:g} to {choice.to_s:g} s"


def _unknown_rules(patterns: tuple[str, ...], header: Header, records: Iterable[Record]) -> Iterator[str]:
    rules = {*_planned(header), *(rule for record in records if (rule := _rule_of(record)))}
    for pattern in patterns:
        if not (filter_names(rules, pattern) or (is_given(pattern) and not _parts(pattern, rules))):
            yield f"rule: must be {_some(rules)}, got {pattern!r}{did_you_mean(pattern, rules)}"


def _unknown_keys(patterns: tuple[str, ...], robots: int, records: Iterable[Record]) -> Iterator[str]:
    """A damaged message may have any key, so those in the log count as well."""
    keys = {*keys_of(robots), *(key for record in records if (key := _key_of(record)))}
    for pattern in patterns:
        if not filter_names(keys, pattern):
            such = "a key of messages in this run, such as link/r1/r2 or body/r1/odometry"
            yield f"key: must be {such}, got {pattern!r}{did_you_mean(pattern, keys)}"


def _planned(header: Header) -> Iterator[str]:
    """The names of the rules of its plan; a damaged header may say anything."""
    match header.faults:
        case {"rule": [*rules]}:
            yield from (str(rule["name"]) for rule in rules if isinstance(rule, dict) and "name" in rule)
        case _:
            pass


def _key_of(record: Record) -> str | None:
    return getattr(record, "key", None)


def _rule_of(record: Record) -> str | None:
    return record.rule if isinstance(record, FaultInjected) else None


def _parts(given: str, rules: Iterable[str]) -> list[str]:
    """What a fault of processes that was given by hand is called for each of them: `given-1.r3`."""
    return filter_names(rules, f"{given}.*")


def _some(rules: Collection[str]) -> str:
    """What a rule of this run may be."""
    if not rules:
        return "a fault rule, and this run has none"
    more = f" or {len(rules) - SHOWN} others" if len(rules) > SHOWN else ""
    return f"one of {', '.join(sorted(rules)[:SHOWN])}{more}"


def unknown_kinds(patterns: tuple[str, ...]) -> str | None:
    """Say which of these patterns no kind matches, with similar names; None: each matches one."""
    unknown = [pattern for pattern in patterns if not filter_names(KINDS, pattern)]
    known = [*KINDS, *sorted({f"{kind.partition('.')[0]}.*" for kind in KINDS})]
    return "; ".join(f"there is no kind {each!r}{did_you_mean(each, known)}" for each in unknown) or None


def _matches(name: object, patterns: tuple[str, ...]) -> bool:
    return isinstance(name, str) and any(fnmatchcase(name, pattern) for pattern in patterns)


def names(record: Record, robot: int) -> bool:
    """Whether a record is about this robot, by one of its fields."""
    return getattr(record, "process", None) == robot_name(robot) or any(
        getattr(record, field, None) == robot for field in NAMING
    )
