"""Tables of a run, as pandas or polars frames where one of them is installed, else as lists of dicts."""

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from importlib.util import find_spec
from operator import attrgetter
from typing import Any

import msgspec

from clew.api.waits import waits_of
from clew.export.columns import Plain
from clew.export.columns import columns_of as typed_columns
from clew.log.journals.messages import FIELDS, Message
from clew.story.story import story_of
from protocol.errors import UsageError
from protocol.files.names import did_you_mean
from protocol.timeline import KINDS, FaultInjected, PoseSampled, kind_of
from protocol.timeline.base import Kind
from protocol.timeline.sentences import sentence
from world.record.lines import Line

Columns = dict[str, list[Any]]

LIBRARIES = ("pandas", "polars")
DICTS = "dicts"
STAMPED = ("t_s", "hlc", "source", "n", "kind")
"""The first columns of every kind, before its own."""


def frame_of(columns: Columns, to: str | None) -> Any:  # noqa: ANN401 - a frame of a library that may be absent
    """The columns as a table.

    Raises:
        UsageError: the library that was asked for is not installed.
    """
    if to is None:
        to = next((each for each in LIBRARIES if find_spec(each) is not None), DICTS)
    if to == DICTS:
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    if to not in LIBRARIES:
        raise UsageError(f"frame: to must be one of {', '.join((*LIBRARIES, DICTS))}, got {to}")
    if find_spec(to) is None:
        raise UsageError(f"frame: {to} is not installed{_extra_of(to)}; to='{DICTS}' needs no library")
    more = {"strict": False} if to == "polars" else {}  # fields of a table may be lists of any length
    return import_module(to).DataFrame(columns, **more)


def _extra_of(library: str) -> str:
    return " (it is in the extra `frames`)" if library == "pandas" else ""


def columns_of(name: str, lines: Sequence[Line], messages: Callable[[], Iterable[Message]]) -> Columns:
    """The columns of a table of a run.

    Raises:
        UsageError: there is no such table.
    """
    if name in KINDS:
        return _of_kind(KINDS[name], lines)
    makers: dict[str, Callable[[], Columns]] = {
        "poses": lambda: _of_kind(PoseSampled, lines, stamp=("t_s",)),
        "steps": lambda: _steps(lines),
        "messages": lambda: _messages(messages()),
        "faults": lambda: _of_kind(FaultInjected, lines),
        "states": lambda: _states(lines),
        "waits": lambda: _waits(lines),
        "entries": lambda: _entries(lines),
    }
    if name not in makers:
        near = did_you_mean(name, (*makers, *KINDS))
        raise UsageError(f"frame: must be one of {', '.join(makers)} or a kind of entry, got {name!r}{near}")
    return makers[name]()


def _of_kind(
    kind: type[Kind], lines: Iterable[Line], stamp: Sequence[str] = ("t_s", "source", "n")
) -> Columns:
    """Column by column, since 100,000 rows one by one would take a second."""
    chosen = [line for line in lines if type(line[1].record) is kind]
    columns: Columns = {}
    for name in stamp:
        columns[name] = [source for source, _ in chosen] if name == "source" else _each(name, chosen)
    records = [entry.record for _, entry in chosen]
    for column in typed_columns(kind)[len(STAMPED) :]:
        values = list(map(attrgetter(column.name), records))
        is_plain = isinstance(column.type, Plain)
        columns[column.name] = values if is_plain else [msgspec.to_builtins(value) for value in values]
    return columns


def _each(name: str, chosen: Sequence[Line]) -> list[Any]:
    get = attrgetter(name)
    return [get(entry) for _, entry in chosen]


def _steps(lines: Iterable[Line]) -> Columns:
    steps = story_of(lines).all_steps()
    plans, ends = [step.plan for step in steps], [step.end for step in steps]
    return {
        "number": [step.number for step in steps],
        "robot": [step.robot for step in steps],
        "planned_s": [step.t_s for step in steps],
        "begun_s": [None if step.begun is None else step.begun.t_s for step in steps],
        "ended_s": [None if end is None else end.t_s for end in ends],
        "how": [None if end is None else str(end.how) for end in ends],
        "x_m": [plan.x_m for plan in plans],
        "y_m": [plan.y_m for plan in plans],
        "target_x_m": [plan.target.x_m for plan in plans],
        "target_y_m": [plan.target.y_m for plan in plans],
        "length_m": [plan.length_m for plan in plans],
        "promised_clearance_m": [plan.promised_clearance_m for plan in plans],
        "clearance_m": [None if end is None else end.clearance_m for end in ends],
    }


def _messages(messages: Iterable[Message]) -> Columns:
    rows = [message.as_dict() for message in messages]
    return {name: [row[name] for row in rows] for name in (*FIELDS, "said")}


def _states(lines: Iterable[Line]) -> Columns:
    changes = sorted(story_of(lines).robots.changes, key=lambda change: change.t_s)
    return {
        "t_s": [change.t_s for change in changes],
        "robot": [change.robot for change in changes],
        "state": [change.state.word for change in changes],
    }


def _waits(lines: Iterable[Line]) -> Columns:
    waits = waits_of(lines)
    return {
        "robot": [wait.robot for wait in waits],
        "whom": [wait.whom for wait in waits],
        "why": [wait.why for wait in waits],
        "from_s": [wait.from_s for wait in waits],
        "to_s": [wait.to_s for wait in waits],
        "wait_s": [wait.wait_s for wait in waits],
    }


def _entries(lines: Sequence[Line]) -> Columns:
    return {
        "t_s": [entry.t_s for _, entry in lines],
        "source": [source for source, _ in lines],
        "n": [entry.n for _, entry in lines],
        "kind": [kind_of(entry.record) for _, entry in lines],
        "sentence": [sentence(source, entry.record) for source, entry in lines],
    }
