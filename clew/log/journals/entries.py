"""Which decision of which process noted an entry of the timeline.

Rule 1: a robot's entries are the notes of its core, in the order of its decisions, and those of its shell
        (`robot.started`, injections, counts). A planned step may come before the other notes of its decision.
Rule 2: the last notes of a process that was killed may never have been recorded.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from agents.commands import Note
from clew.log.journals.process import Process
from protocol.errors import UsageError
from protocol.files.refusals import short
from protocol.plain import plain
from protocol.timeline import KINDS, Entry, RobotStarted, kind_of
from protocol.timeline.sentences import sentence
from world.record.lines import Line

TIME_S = 1e-6  # a core's time may be older than that of its entry, but not newer
NAMED_MAX = 8  # fits on a line of a terminal
AS_PRINTED = re.compile(r"\s*(\d+\.\d{3})\s+(\S+)\s+(\S+\.\S+)\s*(.*)")


@dataclass(frozen=True, slots=True)
class Noted:
    """A turn of a process, in which its core noted an entry."""

    process: Process
    turn: int


def find_entry(lines: Sequence[Line], said: str) -> int:
    """The index of an entry: `r3:17` (source and number), a line of `clew log cat`, or a kind that one has.

    Raises:
        UsageError: there is none such, or more than one.
    """
    if len(given := said.strip().splitlines()) != 1:
        several = sorted({index for each in given for index in _printed(lines, each)})
        raise UsageError(f"{len(given)} entries given; choose one{_named(lines, several)}")
    if (match := re.fullmatch(r"([^\s:]+):(\d{1,16})(?::([1-9]\d{0,3}))?", said, re.ASCII)) is not None:
        source, number, life = match[1], int(match[2]), match[3]
        found = [index for index, (by, entry) in enumerate(lines) if by == source and entry.n == number]
        if life is not None:
            found = found[int(life) - 1 : int(life)]
        how = f"; its processes count from 1 each: choose one as {said}:1"
    elif (match := AS_PRINTED.fullmatch(said)) is not None:
        found = _printed(lines, said)
        how = f"; choose one by its number{_named(lines, found)}"
    elif said in KINDS:
        found = [index for index, (_, entry) in enumerate(lines) if kind_of(entry.record) == said]
        how = f"; choose one{_named(lines, found)}"
    else:
        raise UsageError(
            "an entry is r3:17 (source and number), a line of `clew log cat`, or a kind that one entry has; "
            f"got {short(said)}"
        )
    if not found:
        raise UsageError(f"the log has no entry {said.strip()}; `clew log info` counts those that it has")
    if len(found) > 1:
        raise UsageError(f"the log has {len(found)} entries {said}{how}")
    return found[0]


def _printed(lines: Sequence[Line], said: str) -> list[int]:
    """The entries that `clew log cat` prints as this line."""
    match = AS_PRINTED.fullmatch(said)
    return [
        index
        for index, (by, entry) in enumerate(lines)
        if match is not None
        and (f"{entry.t_s:.3f}", by, kind_of(entry.record)) == (match[1], match[2], match[3])
        and match[4] in {"", plain(sentence(by, entry.record)).strip()}
    ]


def _named(lines: Sequence[Line], found: Sequence[int]) -> str:
    """Source, number and time of entries to choose from, the first few."""
    names = [f"{source}:{entry.n} at {entry.t_s:.1f} s" for source, entry in (lines[at] for at in found)]
    more = ", ..." if len(names) > NAMED_MAX else ""
    return f": {', '.join(names[:NAMED_MAX])}{more}" if names else ""


def noted(processes: Sequence[Process], lines: Sequence[Line], index: int) -> Noted | None:
    """The turn in which a core noted an entry; None: a shell or the world did, or the journal is missing."""
    source, wanted = lines[index]
    newest: Process | None = None
    life: list[Entry] = []
    for by, entry in lines[: index + 1]:
        if by != source:
            continue
        if isinstance(entry.record, RobotStarted):
            found = (
                each
                for each in processes
                if each.name == by and each.head.incarnation == entry.record.incarnation
            )
            newest, life = next(found, None), []
        life.append(entry)
    return None if newest is None else _matched(newest, life, wanted)


def _matched(process: Process, entries: Sequence[Entry], wanted: Entry) -> Noted | None:
    """Rule 1: go through the entries up to the wanted one, and through the notes beside them."""
    notes = [
        (turn, command.record)
        for turn in range(len(process.turns))
        for command in process.commands(turn, only=Note)
        if isinstance(command, Note)
    ]
    used = set[int]()
    first = 0
    place: int | None = None
    for entry in entries:
        place = None
        for at in range(first, len(notes)):
            turn, record = notes[at]
            if process.turns[turn].input.now_s > entry.t_s + TIME_S:
                break
            if at not in used and record == entry.record:
                place = at
                break
        if place is not None:
            used.add(place)
            first = next(at for at, (turn, _) in enumerate(notes) if turn == notes[place][0])
    return None if place is None or entries[-1] is not wanted else Noted(process, notes[place][0])
