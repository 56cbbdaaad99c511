"""Which processes of a run have no journal, according to its log.

Rule 1: every robot in the header has a process, and each process in the log has a journal.
Rule 2: a journal begins with the mission, so a process that was killed before its mission has none. Until
        then, the log shows only its start and the effects on messages to it.
Rule 3: an empty journal is none, and so is one without a whole record.
"""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from msgspec import Struct

from agents.process.journal import SUFFIX, Head, journal_file
from clew.log.journals.recording import NoRecordError, Recording
from clew.log.log import Log
from clew.log.summary import field_of
from protocol.errors import UsageError
from protocol.frames import ROBOTS_MAX
from protocol.keys import robot_number
from protocol.network.session import INPUTS
from protocol.timeline import FaultInjected, MessageRefused, RobotStarted

NEVER_STARTED = "by the log, none of its processes ever started"
NO_MISSION = "by the log it only started, and a journal begins with the mission"

NONE_LEFT = (
    "has no journal, though by the log it took part: it was deleted, could not be written, or is on another"
    " computer"
)
ONLY_EMPTY = (
    "has only an empty journal, though by the log it took part: it could not be written, or was lost with the"
    " disk"
)


class Missing(Struct, frozen=True, kw_only=True):
    """A process of a robot that has no journal."""

    robot: int
    incarnation: str
    """Empty: the log does not say."""
    excuse: str | None
    """Why it may have none; None: it must have one."""
    is_empty: bool
    """Whether its journal is there, without a whole record."""


def journals_in(run: Path, name: str) -> Iterator[Recording]:
    """The journals in the folder of a run (rule 3), of robots of that name or pattern.

    Raises:
        UsageError: a file in the place of a journal is none.
    """
    for path in sorted((run / INPUTS).glob(f"{name}-*{SUFFIX}")):
        with contextlib.suppress(NoRecordError):
            yield Recording(path)


def missing(run: Path, journals: Sequence[Head], robot: int | None) -> tuple[Missing, ...] | None:
    """The processes of one robot, or of all, that have no journal; None: the run has no log."""
    try:
        excuses = _excuses(Log(run))
    except UsageError:
        return None
    kept = {(head.robot, head.incarnation) for head in journals}
    kept |= {(head.robot, "") for head in journals}
    return tuple(
        Missing(
            robot=number,
            incarnation=incarnation,
            excuse=excuse,
            is_empty=journal_file(run / INPUTS, number, incarnation).exists(),
        )
        for (number, incarnation), excuse in sorted(excuses.items())
        if (number, incarnation) not in kept and robot in {None, number}
    )


def told(each: Missing) -> str:
    """For people: which process has no journal, and whether it may have none."""
    who = f"robot {each.robot}" + (f" ({each.incarnation})" if each.incarnation else "")
    if each.excuse is None:
        return f"{who}: {ONLY_EMPTY if each.is_empty else NONE_LEFT}"
    what = "only an empty journal" if each.is_empty else "no journal"
    return f"{who}: has {what}, as it may: {each.excuse}"


def _excuses(log: Log) -> dict[tuple[int, str], str | None]:
    """For each process, by robot and incarnation, why it may have no journal."""
    excuses: dict[tuple[int, str], str | None] = {}
    newest: dict[int, str] = {}
    for source, entry in log.lines:
        if (robot := robot_number(source)) is None:
            continue
        match entry.record:
            case RobotStarted(incarnation=incarnation):
                newest[robot] = incarnation
                excuses[robot, incarnation] = NO_MISSION
            case FaultInjected() | MessageRefused():
                pass  # perhaps of a message from before the mission
            case _:
                excuses[robot, newest.setdefault(robot, "")] = None
    robots = field_of(log.header.scenario, "fleet", "robots")
    asked = range(1, robots + 1) if isinstance(robots, int) and robots <= ROBOTS_MAX else ()
    return excuses | {(robot, ""): NEVER_STARTED for robot in asked if robot not in newest}
