"""The first difference of two timelines. Pure.

Rule 1: values of the wall clock and of the operating system are ignored: hybrid clocks, process ids,
        incarnations, lives, how long a router was away, the name of a run, and when it was started.
Rule 2: entries are compared one by one, in the recorder's order. In a rehearsal the seed decides this order;
        in a live run it does not, because processes race each other.
Rule 3: two live runs are compared by their switching steps: from where to where, by which law, and how near
        to obstacles. Times, and which robots were in sight, are then ignored.
"""

import math
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import islice, zip_longest
from typing import Any

import msgspec
from msgspec import Struct

from protocol.timeline import GoalReached, Record, StepAbandoned, StepFinished, StepPlanned
from world.record.lines import Line
from world.record.recorder import Header

CONTEXT = 3  # entries before and after, like the lines of diff
NO_DIFFERENCE = frozenset({"pid", "incarnation", "life", "lives", "named_life", "away_s"})
NO_DIFFERENCE_OF_STEPS = (
    NO_DIFFERENCE | {"t_s", "n", "epoch", "reach_m", "cost_to_go_m"} | {"obstacles", "gaps", "gap"}
)
OF_A_RUN = frozenset({"hlc", "run", "started_at", "versions", "speed"})
"""Fields of a header that do not decide what happens; the speed matters only in live runs."""

Fields = dict[str, Any]


class Difference(Struct, frozen=True, kw_only=True):
    """The first difference of two runs."""

    entry: int
    """Number of equal entries before it, of those that were compared."""
    fields: tuple[str, ...]
    """What differs, as `target.x_m`; empty: one run has ended."""
    a: Line | None
    """None: this run has ended."""
    b: Line | None
    before: tuple[Line, ...]
    """The last equal entries, as in the first run."""
    after_a: tuple[Line, ...]
    after_b: tuple[Line, ...]


def headers_apart(a: Header, b: Header) -> tuple[str, ...]:
    """What differs in how the runs were started, as `seed` or `scenario.fleet.robots`."""
    one, other = (
        {name: value for name, value in msgspec.to_builtins(header).items() if name not in OF_A_RUN}
        for header in (a, b)
    )
    return tuple(apart(one, other, within=0.0))


def steps_of(lines: Iterable[Line]) -> Iterator[Line]:
    """Rule 3: the entries of the leader's switching steps."""
    return ((source, entry) for source, entry in lines if _is_of_a_step(entry.record))


def _is_of_a_step(record: Record) -> bool:
    match record:
        case StepPlanned(joins=joins):
            return not joins
        case StepFinished() | StepAbandoned() | GoalReached():
            return True
        case _:
            return False


def first_difference(
    a: Iterable[Line], b: Iterable[Line], *, but: frozenset[str] = NO_DIFFERENCE, within: float = 0.0
) -> Difference | None:
    """The first difference; None: the runs are the same.

    Args:
        a: entries in the recorder's order.
        b: the same of the other run.
        but: fields to ignore.
        within: how much numbers may differ.
    """
    ours, theirs = iter(a), iter(b)
    before: deque[Line] = deque(maxlen=CONTEXT)
    for number, (one, other) in enumerate(zip_longest(ours, theirs)):
        if one is None or other is None:
            fields: tuple[str, ...] = ()
        elif not (fields := tuple(apart(_fields(one, but), _fields(other, but), within=within))):
            before.append(one)
            continue
        return Difference(
            entry=number,
            fields=fields,
            a=one,
            b=other,
            before=tuple(before),
            after_a=tuple(islice(ours, CONTEXT)),
            after_b=tuple(islice(theirs, CONTEXT)),
        )
    return None


def _fields(line: Line, but: frozenset[str]) -> Fields:
    source, entry = line
    stamp = {"source": source, "t_s": entry.t_s, "n": entry.n}
    fields = stamp | msgspec.to_builtins(entry.record)
    return {name: value for name, value in fields.items() if name not in but}


def apart(one: Any, other: Any, *, within: float, name: str = "") -> Iterator[str]:  # noqa: ANN401 - any JSON
    """The names of the fields that differ in two JSON values."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in one | other:
            inner = f"{name}.{key}" if name else str(key)
            if key in one and key in other:
                yield from apart(one[key], other[key], within=within, name=inner)
            else:
                yield inner
    elif isinstance(one, list | tuple) and isinstance(other, list | tuple) and len(one) == len(other):
        for index, (left, right) in enumerate(zip(one, other, strict=True)):
            yield from apart(left, right, within=within, name=f"{name}[{index}]")
    elif not (one == other or _are_near(one, other, within)):
        yield name


def _are_near(one: object, other: object, within: float) -> bool:
    return (
        isinstance(one, int | float) and isinstance(other, int | float) and math.fabs(one - other) <= within
    )
