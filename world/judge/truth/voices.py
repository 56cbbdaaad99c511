"""P1 and P7: an entry counts only from the source that it concerns. Pure; entry by entry.

Rule 1 (P7): poses, orders, fences, deaths and all else of `WORLDS` are recorded by the world alone. A fault
        of a process is recorded by the world, or by that process.
Rule 2 (P7): the world has seen the liveliness token of each process of a robot that records more than its
        start, or the process was killed before. The recorder takes no entry of a process before its token; a
        rehearsal has no recorder, so the token may come later than the entry, or never, if the world has lost
        its router, is killed or frozen. A log whose world recorded no incarnation shows nothing about that.
Rule 3 (P1): the goal, a lost route, a healed strand and a new leader are recorded by the robot that leads: it
        has joined the strand, and the fence ALL of that epoch names it.
Rule 4 (P7): an arrival is recorded by a robot that has its place in a strand.
Rule 5 (P7): a formation and those that it strands are recorded by the coordinator of that epoch.
"""

from collections.abc import Iterable, Iterator
from typing import get_args

from protocol.fence import NUMBERS, May
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    BodyStopped,
    Entry,
    FaultInjected,
    FenceChanged,
    GoalReached,
    LeaderSucceeded,
    OrderAccepted,
    OrderFinished,
    OrderRefused,
    PoseSampled,
    PromiseBroken,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RobotStranded,
    RouteLost,
    RouterFound,
    RouterLost,
    RunEnded,
    ScanServed,
    StepFinished,
    StrandFormed,
    StrandHealed,
    StrandJoined,
    ViewJoined,
    ViewLeft,
    WorldResumed,
    kind_of,
)
from world.judge.rules.rule import broken

WORLDS = (
    RobotAppeared
    | RobotDied
    | RobotRestarted
    | RobotReturned
    | FenceChanged
    | OrderAccepted
    | OrderRefused
    | OrderFinished
    | StepFinished
    | BodyStopped
    | PoseSampled
    | ScanServed
    | PromiseBroken
    | RouterLost
    | RouterFound
    | WorldResumed
    | RunEnded
)
"""What the world alone may record."""

_OF_WORLD = frozenset[type](get_args(WORLDS))  # a union of so many types takes long to be searched

LEADERS = GoalReached | RouteLost | LeaderSucceeded | StrandHealed
"""What only the robot that leads may record."""

STOPS = {"kill", "freeze"}
RESUMES = {"start", "thaw"}
"""Of faults of the world's process; a slow one sees tokens, too."""


def concerned(lines: Iterable[tuple[str, Entry]]) -> Iterator[tuple[str, Entry]]:
    """The entries of a timeline that count."""
    voices = Voices()
    return ((source, entry) for source, entry in lines if voices.hear(source, entry) is None)


class Voices:
    """What is known of who may record what."""

    def __init__(self) -> None:
        self._shown: dict[int, set[str]] = {}
        """The incarnations whose tokens the world has seen."""
        self._present: dict[int, str] = {}
        """The incarnation of each robot's newest process."""
        self._unseen: dict[tuple[int, str], float] = {}
        """The others, with the time of the first entry after the start."""
        self._blinded_by: set[str] = set()
        """Why the world sees no tokens now."""
        self._leaders: dict[int, int] = {}
        """The leader by the fence ALL of each epoch."""
        self._joined: dict[int, int] = {}
        """The epoch of the strand in which each robot has its place."""

    def epoch_of(self, robot: int) -> int | None:
        """The epoch of the strand in which a robot has its place, by its own entries."""
        return self._joined.get(robot)

    def hear(self, source: str, entry: Entry) -> PromiseBroken | None:
        """Process an entry; returns why it does not count, if it does not."""
        record, robot = entry.record, robot_number(source)
        if source == WORLD:
            self._hear_world(record)
            return None
        if robot is None:
            return None  # nobody reads the entries of other sources
        breach = self._judge(robot, source, record)
        if breach is None:
            self._hear_robot(robot, record)
        if not isinstance(record, RobotStarted):
            self._speak(robot, entry.t_s)
        return breach

    def close(self) -> Iterator[tuple[float, PromiseBroken]]:
        """Rule 2: there are no more entries."""
        for (robot, _), t_s in self._unseen.items() if self._shown else ():
            yield t_s, broken("P7", robot, "records as a process whose token the world has not seen")

    def _speak(self, robot: int, t_s: float) -> None:
        present = self._present.get(robot)
        if present and not self._blinded_by and present not in self._shown.get(robot, ()):
            self._unseen.setdefault((robot, present), t_s)

    def _hear_world(self, record: Record) -> None:
        match record:
            case RobotAppeared(robot=robot) | RobotRestarted(robot=robot) if record.incarnation:
                self._shown.setdefault(robot, set()).add(record.incarnation)
                self._unseen.pop((robot, record.incarnation), None)
            case FaultInjected(fault=fault, process=process) if process == WORLD:
                if fault in STOPS | RESUMES:
                    self._blind(WORLD, begins=fault in STOPS)
            case FaultInjected(fault="kill", process=str(process)):
                killed = robot_number(process) or 0
                self._unseen.pop((killed, self._present.get(killed, "")), None)
            case FenceChanged(may=May.ALL) as change:
                self._leaders.setdefault(change.epoch, change.named)
            case RouterLost() | RouterFound():
                self._blind("router", begins=isinstance(record, RouterLost))
            case WorldResumed():
                self._blind(WORLD, begins=False)
            case _:
                pass  # says nothing about who may record what

    def _blind(self, why: str, *, begins: bool) -> None:
        """For this reason the world sees no tokens from now on, or not any more."""
        (self._blinded_by.add if begins else self._blinded_by.discard)(why)

    def _hear_robot(self, robot: int, record: Record) -> None:
        match record:
            case StrandJoined(epoch=epoch) if epoch in self._leaders:
                self._joined[robot] = epoch
            case RobotStarted(incarnation=incarnation):
                self._present[robot] = incarnation
                self._joined.pop(robot, None)
            case ViewJoined() | ViewLeft() | StrandJoined():
                self._joined.pop(robot, None)
            case _:
                pass  # does not change its place

    def _judge(self, robot: int, source: str, record: Record) -> PromiseBroken | None:
        does = f"records {kind_of(record)}"
        if isinstance(record, LEADERS):
            return self._judge_leader(robot, does, record)
        why = self._foreign(robot, source, record)
        return None if why is None else broken("P7", robot, f"{does}, {why}")

    def _foreign(self, robot: int, source: str, record: Record) -> str | None:
        """Rules 1, 4 and 5: why an entry does not count."""
        if type(record) in _OF_WORLD:
            return "which only the world may"
        match record:
            case FaultInjected(process=str(process)) if process != source:
                return f"of the process {process}"
            case RobotArrived() if robot not in self._joined:
                return "without a place in a strand"
            case StrandFormed(epoch=epoch) | RobotStranded(epoch=epoch) if epoch % NUMBERS != robot:
                return f"of epoch {epoch}, which robot {epoch % NUMBERS} coordinates"
            case _:
                return None

    def _judge_leader(self, robot: int, does: str, record: LEADERS) -> PromiseBroken | None:
        """Rule 3."""
        match record:
            case GoalReached() | RouteLost():
                epoch = self._joined.get(robot)
            case LeaderSucceeded() | StrandHealed():
                epoch = record.epoch
        leader = None if epoch is None else self._leaders.get(epoch)
        if leader == robot:
            return None
        led = "which another leads" if leader is not None else "which nobody leads"
        where = "without a place in a strand" if epoch is None else f"in epoch {epoch}, {led}"
        return broken("P1", robot, f"{does} {where}", leader)
