"""What holds each robot back, and how its links are, as changes through time.

Rule 1: of what holds a robot back, the first of these counts: it is dead, has arrived, lines up, waits for a
        link, holds for the robot behind. Else it is free, and whether it drives its track says.
Rule 2: a link is as the worse of its two ends saw it: broken, silent, up.
Rule 3: robots' entries may come after later ones of others; changes of one robot, and of one link, never go
        back in time.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

from clew.story.batch import Lane, LinkChange
from protocol.faults.process_faults import ProcessAction
from protocol.keys import robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    MusterJoined,
    Record,
    RobotArrived,
    RobotDied,
    RobotHeld,
    RobotReleased,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    StrandFormed,
)

KINDS = frozenset(
    {
        FaultInjected,
        LinkBroken,
        LinkHeard,
        LinkSilent,
        MusterJoined,
        RobotArrived,
        RobotDied,
        RobotHeld,
        RobotReleased,
        RobotRestarted,
        RobotReturned,
        RobotStarted,
        StrandFormed,
    }
)
"""What lanes and links are made of; the rest need not be heard."""
STOPPED = frozenset({ProcessAction.KILL, ProcessAction.FREEZE})
REVIVED = frozenset({ProcessAction.THAW, ProcessAction.START})

Pair = tuple[int, int]  # the lower number first
ENDS = ("up", "silent", "broken")  # the worse, the later


@dataclass(slots=True)
class _Robot:
    """What is known to hold one robot back."""

    dead: bool = False
    arrived: bool = False
    lining_up: bool = True
    holding: bool = False
    silent: set[int] = field(default_factory=set)
    """The neighbours that it does not hear."""
    told: str = ""
    told_s: float = 0.0

    @property
    def state(self) -> str:
        """Rule 1."""
        if self.dead:
            return "dead"
        if self.arrived:
            return "arrived"
        if self.lining_up:
            return "lining up"
        if self.silent:
            return "waiting"
        return "holding" if self.holding else "free"


@dataclass(slots=True)
class Lanes:
    """Robots and links, as entries tell of them."""

    _robots: defaultdict[int, _Robot] = field(default_factory=lambda: defaultdict(_Robot))
    _ends: dict[tuple[int, int], str] = field(default_factory=dict)
    """How a robot sees its link to a neighbour."""
    _links: dict[Pair, tuple[float, str]] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> Iterator[Lane | LinkChange]:
        """What changes by an entry."""
        writer = robot_number(source)
        robot = self._struck(entry.record) if writer is None else self._told(writer, entry)
        if robot is None:
            return
        lane = self._robots[robot]
        if lane.state != lane.told:
            lane.told, lane.told_s = lane.state, max(lane.told_s, entry.t_s)
            yield Lane(robot=robot, t_s=lane.told_s, state=lane.told)
        yield from self._link_changes(robot, entry)

    def _struck(self, record: Record) -> int | None:
        """The robot that the world, or a fault plan, says something of."""
        match record:
            case RobotDied(robot=robot):
                self._robots[robot].dead = True
            case RobotReturned(robot=robot) | RobotRestarted(robot=robot):
                self._robots[robot].dead = False
            case FaultInjected(fault=fault, process=str(process)):
                struck = robot_number(process)
                if struck is None or fault not in STOPPED | REVIVED:
                    return None
                robot = struck
                self._robots[robot].dead = fault in STOPPED
            case _:
                return None
        return robot

    def _told(self, robot: int, entry: Entry) -> int:
        """A robot says something of itself."""
        lane = self._robots[robot]
        match entry.record:
            case RobotStarted():
                self._robots[robot] = _Robot(told=lane.told, told_s=lane.told_s)
            case RobotArrived():
                lane.arrived = True
            case MusterJoined():
                lane.lining_up, lane.arrived, lane.holding = True, False, False
                lane.silent.clear()
            case StrandFormed():
                lane.lining_up, lane.arrived = False, False
            case RobotHeld():
                lane.holding = True
            case RobotReleased():
                lane.holding = False
            case LinkSilent(neighbour=neighbour):
                lane.silent.add(neighbour)
            case LinkHeard(neighbour=neighbour) | LinkBroken(neighbour=neighbour):
                lane.silent.discard(neighbour)
            case FaultInjected(fault=fault, process=str()) if fault in STOPPED:
                lane.dead = True  # it strikes itself, at a named point of its step
            case _:
                pass
        return robot

    def _link_changes(self, robot: int, entry: Entry) -> Iterator[LinkChange]:
        match entry.record:
            case LinkSilent(neighbour=neighbour):
                state = "silent"
            case LinkBroken(neighbour=neighbour):
                state = "broken"
            case LinkHeard(neighbour=neighbour):
                state = "up"
            case StrandFormed(order=order) if robot in order:
                place = order.index(robot)
                for neighbour in (*order[max(place - 1, 0) : place], *order[place + 1 : place + 2]):
                    yield from self._see(robot, neighbour, "up", entry.t_s)
                return
            case _:
                return
        yield from self._see(robot, neighbour, state, entry.t_s)

    def _see(self, robot: int, neighbour: int, state: str, t_s: float) -> Iterator[LinkChange]:
        """Rule 2."""
        self._ends[robot, neighbour] = state
        one, other = sorted((robot, neighbour))
        worse = max(state, self._ends.get((neighbour, robot), "up"), key=ENDS.index)
        before_s, before = self._links.get((one, other), (0.0, ""))
        if worse != before:
            self._links[one, other] = max(before_s, t_s), worse
            yield LinkChange(one=one, other=other, t_s=max(before_s, t_s), state=worse)
