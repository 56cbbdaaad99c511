"""What a robot may do, and by which entries that changes: tables that `clew/story/robots.py` goes by. Pure.

Rule 1: a state has three parts, each with a table of its own: whether the robot's process runs (`PROCESS`),
        what it does in the strand (`CONDUCT`), and what keeps it from driving (`BEGINS`, `ENDS`, `ANEW`).
Rule 2: of all that holds, the first in `TELLING` is its state: what tells the most.
Rule 3: the world and the fault plan say whether a process lives; all else a robot says of itself.
"""

from collections.abc import Iterable, Mapping
from enum import Enum, IntEnum, auto
from typing import TypeVar

from protocol.faults.process_faults import ProcessAction
from protocol.keys import robot_number
from protocol.timeline import (
    BodyStopped,
    FaultInjected,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    MusterJoined,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotBlocked,
    RobotDied,
    RobotFailed,
    RobotHeld,
    RobotPlaced,
    RobotReleased,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RouteLost,
    StrandFormed,
)


class State(IntEnum):
    """What a robot does. Where not all rows fit, those of the least come first: they tell the most."""

    NO_WAY = auto()
    FAILED = auto()
    DEAD = auto()
    KILLED = auto()
    FROZEN = auto()
    STOPPED = auto()
    ADRIFT = auto()
    WAITING = auto()
    BLOCKED = auto()
    JOINING = auto()
    LEADING = auto()
    HOLDING = auto()
    FOLLOWING = auto()
    ARRIVED = auto()
    ABSENT = auto()

    @property
    def is_end(self) -> bool:
        """Whether its process runs no more, or stands still."""
        return State.FAILED <= self <= State.FROZEN


class Process(Enum):
    """A robot's process."""

    ABSENT = auto()
    RUNS = auto()
    KILLED = auto()
    FROZEN = auto()
    FAILED = auto()
    DEAD = auto()
    """The world has given it up."""


class Conduct(Enum):
    """What a robot does in the strand."""

    JOINING = auto()
    IN_STRAND = auto()
    ARRIVED = auto()
    ADRIFT = auto()
    """It has given a link up, and joined no muster since."""
    NO_WAY = auto()


class Kept(Enum):
    """What keeps a robot from driving."""

    STOPPED = auto()
    """The dead-man stop of its body."""
    SILENCE = auto()
    BLOCKED = auto()
    HELD = auto()


_ACTIONS = frozenset(ProcessAction)
Event = type[Record] | ProcessAction
"""What changes a state: a kind of entry, or what was done to a process."""

_S = TypeVar("_S")


def _from_each(states: Iterable[_S], becomes: Mapping[Event, _S]) -> dict[tuple[_S, Event], _S]:
    """Transitions that are the same from each of these states."""
    return {(before, event): after for before in states for event, after in becomes.items()}


PROCESS: dict[tuple[Process, Event], Process] = _from_each(
    Process,
    {
        RobotAppeared: Process.RUNS,
        RobotStarted: Process.RUNS,
        RobotRestarted: Process.RUNS,
        RobotReturned: Process.RUNS,
        RobotDied: Process.DEAD,
        RobotFailed: Process.FAILED,
        ProcessAction.KILL: Process.KILLED,
        ProcessAction.FREEZE: Process.FROZEN,
    },
) | {(Process.FROZEN, ProcessAction.THAW): Process.RUNS}
"""How a process goes on; what is not here changes nothing."""

CONDUCT: dict[tuple[Conduct, Event], Conduct] = _from_each(
    set(Conduct) - {Conduct.NO_WAY},  # the run ends there
    {
        RobotStarted: Conduct.JOINING,
        RobotRestarted: Conduct.JOINING,
        MusterJoined: Conduct.JOINING,
        StrandFormed: Conduct.IN_STRAND,
        LinkBroken: Conduct.ADRIFT,
        RobotArrived: Conduct.ARRIVED,
        RouteLost: Conduct.NO_WAY,
    },
)
"""How its conduct goes on; what is not here changes nothing."""

BEGINS: dict[Event, Kept] = {
    BodyStopped: Kept.STOPPED,
    LinkSilent: Kept.SILENCE,
    RobotBlocked: Kept.BLOCKED,
    RobotHeld: Kept.HELD,
}
ENDS: dict[Event, Kept] = {
    LinkHeard: Kept.SILENCE,
    RobotPlaced: Kept.BLOCKED,
    RobotReleased: Kept.HELD,
}
ANEW: frozenset[Event] = frozenset({RobotStarted, RobotRestarted, MusterJoined, StrandFormed, LinkBroken})
"""After these a robot has no place, or a new one, and none of its former waits but the dead-man stop."""

OF_PROCESS = {
    Process.ABSENT: State.ABSENT,
    Process.KILLED: State.KILLED,
    Process.FROZEN: State.FROZEN,
    Process.FAILED: State.FAILED,
    Process.DEAD: State.DEAD,
}
TELLING: tuple[tuple[Conduct | Kept, State], ...] = (
    (Conduct.NO_WAY, State.NO_WAY),
    (Conduct.ARRIVED, State.ARRIVED),
    (Kept.STOPPED, State.STOPPED),
    (Conduct.ADRIFT, State.ADRIFT),
    (Kept.SILENCE, State.WAITING),
    (Kept.BLOCKED, State.BLOCKED),
    (Conduct.JOINING, State.JOINING),
    (Kept.HELD, State.HOLDING),
)
"""Rule 2, of a robot whose process runs; of none of them it leads or follows."""
KINDS: frozenset[Event] = frozenset(
    {FaultInjected, *(event for _, event in (*PROCESS, *CONDUCT)), *BEGINS, *ENDS}
)


def event_of(source: str, record: Record) -> tuple[int, Event] | None:
    """Rule 3: which robot an entry tells of, and what; None: of none."""
    kind = type(record)
    if isinstance(record, FaultInjected):
        struck = None if record.process is None else robot_number(record.process)
        if struck is None or record.fault not in _ACTIONS:
            return None
        return struck, ProcessAction(record.fault)
    if kind not in KINDS:
        return None
    robot = robot_number(source) or getattr(record, "robot", None)
    return None if robot is None else (robot, kind)
