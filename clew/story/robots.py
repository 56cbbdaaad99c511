"""What each robot does, by what the timeline has said of it so far. Pure.

Rule 1: a state has three parts, each with a table of its own: whether the robot's process runs (`PROCESS`),
        what it does in the strand (`CONDUCT`), and what keeps it from driving (`BEGINS`, `ENDS`, `ANEW`).
Rule 2: of all that holds, the first in `TELLING` is its state: what tells the most.
Rule 3: the world and the fault plan say whether a process lives; all else a robot says of itself.
Rule 4: entries of one robot may come after later ones of others; its changes never go back in time.
"""

from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from enum import Enum, IntEnum, auto
from typing import TypeVar

from protocol.faults.process_faults import ProcessAction
from protocol.keys import robot_number
from protocol.timeline import (
    BodyStopped,
    Entry,
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


@dataclass(slots=True)
class Robot:
    """One robot, as far as the timeline has told of it."""

    number: int
    process: Process = Process.ABSENT
    conduct: Conduct = Conduct.JOINING
    place: int | None = None
    """In the strand; the leader's is 0."""
    epoch: int = 0
    """The newest in which it has had a place."""
    kept: set[tuple[Kept, int]] = field(default_factory=set)
    """What keeps it, and which neighbour is silent; 0: it is no neighbour."""

    @property
    def state(self) -> State:
        """Rule 2."""
        return self._telling({self.conduct, *(kept for kept, _ in self.kept)})

    @property
    def doing(self) -> State:
        """The same of the robot alone, whatever has stopped its body."""
        return self._telling({self.conduct, *(kept for kept, _ in self.kept if kept is not Kept.STOPPED)})

    def _telling(self, holds: AbstractSet[Conduct | Kept]) -> State:
        if self.process is not Process.RUNS:
            return OF_PROCESS[self.process]
        otherwise = State.LEADING if self.place == 0 else State.FOLLOWING
        return next((state for part, state in TELLING if part in holds), otherwise)

    @property
    def silent(self) -> tuple[int, ...]:
        """The neighbours that it does not hear."""
        return tuple(sorted(neighbour for kept, neighbour in self.kept if kept is Kept.SILENCE))

    def take(self, event: Event, record: Record | None = None) -> None:
        """Something has happened to it, by this record where it has more to say."""
        self.process = PROCESS.get((self.process, event), self.process)
        self.conduct = CONDUCT.get((self.conduct, event), self.conduct)
        neighbour = getattr(record, "neighbour", 0)
        if event in ANEW:
            self.place = None
            self.kept &= {(Kept.STOPPED, 0)}
        if event in BEGINS:
            self.kept.add((BEGINS[event], neighbour))
        elif event in ENDS:
            self.kept.discard((ENDS[event], neighbour))
        match record:
            case StrandFormed(epoch=epoch, order=order) if self.number in order:
                self.epoch, self.place = epoch, order.index(self.number)
            case RobotPlaced(rank=rank):
                self.place = rank
            case _:
                pass  # says nothing of its place

    def move(self) -> None:
        """Its body has moved: nothing stops it any more."""
        self.kept.discard((Kept.STOPPED, 0))


@dataclass(frozen=True, slots=True)
class Change:
    """A robot is in this state from a time on."""

    t_s: float
    robot: int
    state: State
    doing: State
    """`state` but for a dead-man stop."""


@dataclass(slots=True)
class Robots:
    """All robots, and how their states have changed."""

    each: dict[int, Robot] = field(default_factory=dict)
    changes: list[Change] = field(default_factory=list)
    """In the order in which they were heard of."""
    _newest: dict[int, Change] = field(default_factory=dict)

    def of(self, robot: int) -> Robot:
        """A robot; of one that nothing has been heard of nothing is known."""
        found = self.each.get(robot)
        if found is None:
            found = self.each[robot] = Robot(robot)
        return found

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        told = _event(source, entry.record)
        if told is not None:
            robot = self.of(told[0])
            robot.take(told[1], entry.record)
            self._note(entry.t_s, robot)

    def move(self, t_s: float, robot: int) -> None:
        """The body of a robot has moved."""
        moved = self.of(robot)
        if moved.kept:
            moved.move()
            self._note(t_s, moved)

    def _note(self, t_s: float, robot: Robot) -> None:
        """Rule 4."""
        before, now = self._newest.get(robot.number), (robot.state, robot.doing)
        if before is None or (before.state, before.doing) != now:
            at_s = t_s if before is None else max(t_s, before.t_s)
            change = self._newest[robot.number] = Change(at_s, robot.number, *now)
            self.changes.append(change)


def _event(source: str, record: Record) -> tuple[int, Event] | None:
    """Rule 3: which robot an entry tells of, and what; None: of none."""
    kind = type(record)
    if isinstance(record, FaultInjected):
        struck = None if record.process is None else robot_number(record.process)
        return (
            None if struck is None or record.fault not in _ACTIONS else (struck, ProcessAction(record.fault))
        )
    if kind not in KINDS:
        return None
    robot = robot_number(source) or getattr(record, "robot", None)
    return None if robot is None else (robot, kind)


_ACTIONS = frozenset(ProcessAction)
