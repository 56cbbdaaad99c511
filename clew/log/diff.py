"""The first difference of two timelines. Pure.

Rule 1: what the wall clock and the operating system say is no difference: hybrid clocks, process ids,
        incarnations, how long a router was away; nor what a run is called and when it was started.
Rule 2: entries are compared one by one, in the recorder's order. A rehearsal's is decided by its seed; a live
        run's is not: its processes race each other.
Rule 3: what two live runs have in common are their switching steps: from where to where, by which law, and
        how near to obstacles. When that was, and which robots stood in sight, is no difference then.
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

CONTEXT = 3  # entries on either side, as diff has lines
NO_DIFFERENCE = frozenset({"pid", "incarnation", "away_s"})
NO_DIFFERENCE_OF_STEPS = (
    NO_DIFFERENCE | {"t_s", "n", "epoch", "reach_m", "cost_to_go_m"} | {"obstacles", "gaps", "gap"}
)
OF_A_RUN = frozenset({"hlc", "run", "started_at", "versions", "speed"})
"""What of a header says nothing of what happens; the speed does so only in live runs."""

Fields = dict[str, Any]


class Difference(Struct, frozen=True, kw_only=True):
    """Where two runs part."""

    entry: int
    """How many entries they have in common before it, of those that were compared."""
    fields: tuple[str, ...]
    """What differs, as `target.x_m`; all, where one is no entry of the same kind, or is not there."""
    a: Line | None
    """None: that run has ended here."""
    b: Line | None
    before: tuple[Line, ...]
    """The last in common, as the first run has them."""
    after_a: tuple[Line, ...]
    after_b: tuple[Line, ...]


def headers_apart(a: Header, b: Header) -> tuple[str, ...]:
    """What the two runs were asked to do differently, as `seed` or `scenario.fleet.robots`."""
    one, other = (
        {name: value for name, value in msgspec.to_builtins(header).items() if name not in OF_A_RUN}
        for header in (a, b)
    )
    return tuple(apart(one, other, within=0.0))


def steps_of(lines: Iterable[Line]) -> Iterator[Line]:
    """Rule 3: what the leader's switching steps came to."""
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
    """Where two runs part; None where they never do.

    Args:
        a: entries in the recorder's order.
        b: likewise.
        but: fields that are no difference.
        within: by how much numbers may differ.
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
    """The names of what differs in two values of JSON."""
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
