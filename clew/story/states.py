"""What a robot may do, and by which entries that changes: tables that `clew/story/robots.py` goes by. Pure.

Rule 1: a state has three parts, each with a table of its own: whether the robot's process runs (`PROCESS`),
        what it does in the strand (`CONDUCT`), and what keeps it from driving (`BEGINS`, `ENDS`, `ANEW`).
Rule 2: of all that holds, the first in `TELLING` is its state: what tells the most.
Rule 3: the world and the fault plan say whether a process lives, and the fence says who has a turn; that a
        robot is stranded its coordinator says. All else a robot says of itself.
"""

from collections.abc import Iterable, Mapping
from enum import Enum, IntEnum, auto
from typing import TypeVar

from protocol.faults.process_faults import ProcessAction
from protocol.keys import robot_number
from protocol.timeline import (
    BodyStopped,
    FaultInjected,
    FenceChanged,
    LinkBroken,
    LinkHeard,
    LinkSilent,
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
    RobotStranded,
    RouteLost,
    StrandFormed,
    StrandJoined,
    ViewJoined,
    ViewLeft,
)


class State(IntEnum):
    """What a robot does. Where not all rows fit, those of the least come first: they tell the most."""

    NO_WAY = auto()
    FAILED = auto()
    DEAD = auto()
    KILLED = auto()
    FROZEN = auto()
    STOPPED = auto()
    STRANDED = auto()
    ASIDE = auto()
    ADRIFT = auto()
    WAITING = auto()
    BLOCKED = auto()
    JOINING = auto()
    BOUND = auto()
    LEADING = auto()
    BACKING_UP = auto()
    HOLDING = auto()
    FOLLOWING = auto()
    ARRIVED = auto()
    ABSENT = auto()

    @property
    def is_end(self) -> bool:
        """Whether its process runs no more, or stands still."""
        return State.FAILED <= self <= State.FROZEN

    @property
    def word(self) -> str:
        """Its name in lower case, as `backing up`; the live table and the page have words of their own."""
        return self.name.lower().replace("_", " ")


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
    """What a robot does in the strand or in a view."""

    BOUND = auto()
    """It stands and reports to the coordinator of a view, or is about to."""
    JOINING = auto()
    """It has the turn: it drives to its place."""
    MEMBER = auto()
    BACKING_UP = auto()
    """It is a member of a strand that goes back along its path."""
    ARRIVED = auto()
    ASIDE = auto()
    """It is left out of the strand."""
    ADRIFT = auto()
    """It has given a link up, and joined no view since."""
    NO_WAY = auto()


class Kept(Enum):
    """What keeps a robot from driving."""

    STOPPED = auto()
    """The dead-man stop of its body."""
    STRANDED = auto()
    """Its coordinator finds no way for it."""
    SILENCE = auto()
    BLOCKED = auto()
    HELD = auto()


class Derived(Enum):
    """What an entry about the whole strand means for one robot."""

    TURN_GIVEN = auto()
    TURN_ENDED = auto()
    BACKS_UP = auto()


_ACTIONS = frozenset(ProcessAction)
Event = type[Record] | ProcessAction | Derived
"""What changes a state: a kind of entry, what was done to a process, or what follows for a robot."""

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

_GOES_ON = set(Conduct) - {Conduct.NO_WAY}  # the run ends there
CONDUCT: dict[tuple[Conduct, Event], Conduct] = (
    _from_each(
        _GOES_ON,
        {
            RobotStarted: Conduct.BOUND,
            RobotRestarted: Conduct.BOUND,
            Derived.TURN_GIVEN: Conduct.JOINING,
            StrandJoined: Conduct.MEMBER,
            ViewLeft: Conduct.ASIDE,
            LinkBroken: Conduct.ADRIFT,
            RobotArrived: Conduct.ARRIVED,
            RouteLost: Conduct.NO_WAY,
        },
    )
    # A turn that is over has ended by the fence, so this entry has come late, from before the turn.
    | _from_each(_GOES_ON - {Conduct.JOINING}, {ViewJoined: Conduct.BOUND})
    | {
        (Conduct.JOINING, Derived.TURN_ENDED): Conduct.BOUND,
        (Conduct.MEMBER, Derived.BACKS_UP): Conduct.BACKING_UP,
    }
)
"""How its conduct goes on; what is not here changes nothing."""

BEGINS: dict[Event, Kept] = {
    BodyStopped: Kept.STOPPED,
    RobotStranded: Kept.STRANDED,
    LinkSilent: Kept.SILENCE,
    RobotBlocked: Kept.BLOCKED,
    RobotHeld: Kept.HELD,
}
ENDS: dict[Event, Kept] = {
    LinkHeard: Kept.SILENCE,
    Derived.TURN_GIVEN: Kept.BLOCKED,
    RobotPlaced: Kept.BLOCKED,
    RobotReleased: Kept.HELD,
}
ANEW: dict[Event, frozenset[Kept]] = {
    RobotStarted: frozenset({Kept.STOPPED}),
    RobotRestarted: frozenset({Kept.STOPPED}),
    ViewJoined: frozenset({Kept.STOPPED}),
    StrandJoined: frozenset({Kept.STOPPED}),
    LinkBroken: frozenset({Kept.STOPPED}),
    ViewLeft: frozenset({Kept.STOPPED, Kept.STRANDED}),
}
"""After these a robot has no place, or a new one; and what still keeps it then."""

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
    (Kept.STRANDED, State.STRANDED),
    (Conduct.ASIDE, State.ASIDE),
    (Conduct.ADRIFT, State.ADRIFT),
    (Kept.SILENCE, State.WAITING),
    (Kept.BLOCKED, State.BLOCKED),
    (Conduct.JOINING, State.JOINING),
    (Conduct.BOUND, State.BOUND),
    (Kept.HELD, State.HOLDING),
    (Conduct.BACKING_UP, State.BACKING_UP),
)
"""Rule 2, of a robot whose process runs; of none of them it leads or follows."""
EVENTS: frozenset[Event] = frozenset({*(event for _, event in (*PROCESS, *CONDUCT)), *BEGINS, *ENDS})
KINDS: frozenset[Event] = EVENTS | {FaultInjected, FenceChanged, StrandFormed}


def event_of(source: str, record: Record) -> tuple[int, Event] | None:
    """Rule 3: which robot an entry tells of, and what; None: of none."""
    kind = type(record)
    if isinstance(record, FaultInjected):
        struck = None if record.process is None else robot_number(record.process)
        if struck is None or record.fault not in _ACTIONS:
            return None
        return struck, ProcessAction(record.fault)
    if isinstance(record, RobotStranded):
        return record.robot, kind
    if kind not in EVENTS:
        return None
    robot = robot_number(source) or getattr(record, "robot", None)
    return None if robot is None else (robot, kind)
