"""How one robot stands, by what the timeline has said of it so far. Pure.

Rule 1: whether its process lives, the world and the fault plan say; all else the robot says of itself.
Rule 2: a robot that has left one strand, or joined the next, has none of the old one's waits any more.
"""

from dataclasses import dataclass, field
from enum import IntEnum, auto

from protocol.faults.process_faults import ProcessAction
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


_STRUCK = {ProcessAction.KILL: State.KILLED, ProcessAction.FREEZE: State.FROZEN}


@dataclass(slots=True)
class Standing:
    """One robot, as far as the timeline has told of it."""

    robot: int
    place: int | None = None
    """In the strand; the leader's is 0."""
    epoch: int = 0
    gone: State | None = State.ABSENT
    """Why there is no process that runs; None: there is one."""
    formed: bool = False
    arrived: bool = False
    silent: set[int] = field(default_factory=set)
    """Neighbours that are not heard."""
    adrift: bool = False
    """It has given a link up, and joined no muster since."""
    _held: bool = False
    _stopped: bool = False
    _blocked: bool = False
    _no_way: bool = False

    @property
    def state(self) -> State:
        """What it does: of all that holds, what tells the most."""
        holds = {
            State.NO_WAY: self._no_way,
            State.ARRIVED: self.arrived,
            State.STOPPED: self._stopped,
            State.ADRIFT: self.adrift,
            State.WAITING: bool(self.silent),
            State.BLOCKED: self._blocked,
            State.JOINING: not self.formed,
            State.HOLDING: self._held,
            State.LEADING: self.place == 0,
        }
        doing = next((state for state, is_so in holds.items() if is_so), State.FOLLOWING)
        return doing if self.gone is None else self.gone

    def move(self) -> None:
        """Its body has moved: nothing stops it any more."""
        self._stopped = False

    def hear_world(self, record: Record) -> None:
        """What the world, or a fault plan, says of its process and its body."""
        match record:
            case RobotDied():
                self.gone = State.DEAD
            case RobotAppeared() | RobotReturned():
                self.gone = None
            case RobotRestarted():
                self.gone = None
                self._leave()
            case FaultInjected(fault=ProcessAction.THAW) if self.gone is State.FROZEN:
                self.gone = None
            case FaultInjected(fault=fault) if fault in tuple(_STRUCK):
                self.gone = _STRUCK[ProcessAction(fault)]
            case BodyStopped():
                self._stopped = True
            case _:
                pass  # tells nothing of how it stands

    def hear_itself(self, record: Record) -> None:
        """What it says of itself."""
        match record:
            case StrandFormed(epoch=epoch, order=order):
                self._leave()
                self.formed, self.epoch, self.place = True, epoch, order.index(self.robot)
            case MusterJoined():
                self._leave()
            case LinkBroken():
                self._leave()
                self.adrift = True
            case RobotPlaced(rank=rank):
                self.place, self._blocked = rank, False
            case RobotArrived():
                self.arrived = True
            case RouteLost():
                self._no_way = True
            case RobotFailed():
                self.gone = State.FAILED
            case _:
                self._hear_waits(record)

    def _hear_waits(self, record: Record) -> None:
        match record:
            case LinkSilent(neighbour=neighbour):
                self.silent.add(neighbour)
            case LinkHeard(neighbour=neighbour):
                self.silent.discard(neighbour)
            case RobotHeld():
                self._held = True
            case RobotReleased():
                self._held = False
            case RobotBlocked():
                self._blocked = True
            case _:
                pass  # it waits for nothing else

    def _leave(self) -> None:
        """Rule 2."""
        self.place = None
        self.adrift = self.formed = self.arrived = self._held = self._blocked = False
        self.silent.clear()
