"""The counts and facts of a run, from its entries. An entry counts only from the source that it concerns."""

import math
from collections import Counter, defaultdict
from collections.abc import Set
from dataclasses import dataclass, field

from msgspec.structs import replace

from protocol.fence import May
from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.network.traffic import joined
from protocol.timeline import (
    Entry,
    FaultInjected,
    FenceChanged,
    GoalReached,
    LinkBroken,
    OrderAccepted,
    PoseSampled,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotSettled,
    RobotStranded,
    RouteLost,
    ScanServed,
    StepFinished,
    StrandFormed,
    StrandJoined,
    TrafficCounted,
    ViewJoined,
    WorldResumed,
)
from world.judge.attempt import Attempt
from world.judge.books import TAKES_AWAY, Book
from world.judge.recovery import KILLED, ORDERED, THAWED, Dated, is_relevant, summary
from world.judge.truth.voices import Voices


@dataclass(slots=True)
class Tally:
    """The counts and facts of a run, from the timeline alone."""

    arrived: set[int] = field(default_factory=set)
    settled: dict[int, RobotSettled] = field(default_factory=dict)
    counted: dict[int, TrafficCounted] = field(default_factory=dict)
    recovery: list[Dated] = field(default_factory=list)
    """The entries from which `world.judge.recovery` finds deaths, successions and heals."""
    died: set[int] = field(default_factory=set)
    restarted: set[int] = field(default_factory=set)
    disturbed_s: float | None = None
    """When a robot last died, returned, or broke a link."""
    arrived_s: float = 0.0
    """When a robot last arrived."""
    stranded: dict[int, RobotStranded] = field(default_factory=dict)
    """The robots that the newest formation has no way for, with the newest entry about each."""
    stranded_s: float = 0.0
    """When a robot was last said to be stranded, or a formation was made."""
    stranded_before_s: float = -math.inf
    """When the formation before the newest was made, if both found no way for the same robots, and one had
    arrived by the newest."""
    route_lost: tuple[float, RouteLost] | None = None
    goal_reached: bool = False
    over_s: float = math.inf
    """When the run was over: what a robot does later takes nothing from its arrival."""
    is_resumed: bool = False
    """Whether the world that knew when the run was over may have been killed: robots that settle tell it."""
    switching_steps: int = 0
    switching_positions: list[Point] = field(default_factory=list)
    """The leader's positions before its first step and after each step [world frame]."""
    planning_events: int = 0
    """Scans served to robots: each is queried to decide on a motion."""
    scans: int = 0
    attempt: Attempt = field(default_factory=Attempt)
    """What the fleet was trying last."""
    struck: set[str] = field(default_factory=set)
    """The rules of fault plans that struck at least once."""
    stopped: dict[int, str] = field(default_factory=dict)
    """The robots that a fault has stopped, and by what: `freeze` (until a thaw) or `kill`."""
    world_down: FaultInjected | None = None
    """The fault that ended or froze the world's process; None: that runs, or does again."""
    _voices: Voices = field(default_factory=Voices)
    _bound: dict[int, float] = field(default_factory=dict)
    """When robots that had arrived were bound in another view, or were in another strand."""
    _left_s: defaultdict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    """When robots had a turn, or were in another strand: from then on they may have left their places."""
    order: tuple[int, ...] = ()
    """The robots of the newest formation."""
    _formed: int = 0
    """Its epoch."""
    _formed_s: float = -math.inf
    _left_out: frozenset[int] = frozenset()
    """The robots that the newest formation has no way for, if nothing has happened since."""
    removed: defaultdict[Book, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    """Recorded removals of messages, by book and fault."""
    _struck: dict[Book, tuple[int, str]] = field(default_factory=dict)
    """The newest removed message of each book, and the fault that removed it last."""

    @property
    def unrecorded_count(self) -> int:
        """Entries that robots had to drop before they were recorded."""
        return sum(counted.unrecorded for counted in self.counted.values())

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry."""
        if isinstance(entry.record, PoseSampled):
            return  # more than half of all entries; nothing is counted here from samples
        if self._voices.hear(source, entry) is not None:
            return
        if isinstance(entry.record, FaultInjected):
            self._hear_fault(source, entry.record)
        self.attempt.hear(source, entry)
        robot = robot_number(source)
        if is_relevant(source, entry.record):
            self.recovery.append((entry.t_s, source, summary(entry.record)))
        if source == WORLD:
            self._hear_world(entry)
        elif robot is not None:
            self._hear_robot(robot, entry)

    def _hear_fault(self, source: str, injected: FaultInjected) -> None:
        self.struck.add(injected.rule)
        if (source, injected.process) == (WORLD, WORLD) and injected.fault not in {"slow", "unslow"}:
            self.world_down = injected if injected.fault in ORDERED else None
        if injected.process is not None and source in {WORLD, injected.process}:
            self._stop(robot_number(injected.process), injected.fault)
        counts_no_more = robot_number(source) in self.counted  # odometry arrives until the process ends
        if injected.key and injected.number and injected.fault in TAKES_AWAY and not counts_no_more:
            self._remove((injected.key, source), injected.number, injected.fault)

    def _stop(self, robot: int | None, fault: str) -> None:
        """A fault has struck a process. To thaw a killed one changes nothing."""
        if robot is not None and fault in ORDERED and self.stopped.get(robot) != KILLED:
            self.stopped[robot] = fault
        elif fault == THAWED and self.stopped.get(robot or 0) != KILLED:
            self.stopped.pop(robot or 0, None)

    def _remove(self, book: Book, number: int, fault: str) -> None:
        """A fault has removed a message; of several in a row that did, the last one counts."""
        before, by = self._struck.get(book, (0, fault))
        self._struck[book] = number, fault
        counts = self.removed[book]
        counts[fault] += 1
        if number == before:
            counts.subtract([by])
            self.removed[book] = +counts

    def end(self, t_s: float) -> None:
        """The run is over, or was by then."""
        self.over_s = min(self.over_s, t_s)
        self.arrived |= {robot for robot, at_s in self._bound.items() if not self._has_left(robot, at_s)}

    def _has_left(self, robot: int, bound_s: float) -> bool:
        """Whether a robot that was bound then may have left its place before the run was over."""
        return any(bound_s <= left_s < self.over_s for left_s in self._left_s.get(robot, ()))

    def _hear_world(self, entry: Entry) -> None:
        match entry.record:
            case RobotDied(robot=robot):
                self.died.add(robot)
                self._disturb(entry.t_s)
            case RobotRestarted(robot=robot):
                self.restarted.add(robot)
                self.stopped.pop(robot, None)
                self.arrived.discard(robot)  # it has lost its place
                self._bound.pop(robot, None)
                self._disturb(entry.t_s)
            case RobotReturned():
                self._disturb(entry.t_s)
            case WorldResumed():
                self.world_down = None
            case FenceChanged(may=May.ONE, named=robot):
                self._left_s[robot].append(entry.t_s)
            case ScanServed(revolutions=revolutions):
                self.planning_events += 1
                self.scans += revolutions
            case OrderAccepted(step=1) as order if not self.switching_positions:
                self.switching_positions.append(Point(x_m=order.x_m, y_m=order.y_m))
            case StepFinished() as step:
                self.switching_steps += 1
                self.switching_positions.append(Point(x_m=step.x_m, y_m=step.y_m))
            case _:
                pass  # not counted

    def _hear_robot(self, robot: int, entry: Entry) -> None:
        match entry.record:
            case GoalReached():
                self.goal_reached = True
            case RobotArrived():
                self.arrived.add(robot)
                self.arrived_s = max(self.arrived_s, entry.t_s)
            case StrandJoined() | ViewJoined() as bound:
                self._bind(robot, entry.t_s, stands=isinstance(bound, ViewJoined))
            case StrandFormed() as formed:
                self._form(formed, entry.t_s)
            case RobotStranded() as stranded if stranded.epoch >= self._formed:
                self._strand(stranded, entry.t_s)
            case LinkBroken():
                self._disturb(entry.t_s)
            case RouteLost() as lost:
                self.route_lost = self.route_lost or (entry.t_s, lost)
            case RobotSettled() as settled:
                self._settle(robot, settled, entry.t_s)
            case TrafficCounted() as counted:
                before = self.counted.get(robot)
                self.counted[robot] = counted if before is None else joined(before, counted)
            case _:
                pass  # not counted

    def _bind(self, robot: int, t_s: float, *, stands: bool) -> None:
        """A robot is in another view, in which it stands until it has a turn; or in another strand."""
        if not stands:
            self._left_s[robot].append(t_s)
        if t_s < self.over_s and robot in self.arrived:
            self.arrived.discard(robot)
            self._bound[robot] = t_s
        if math.isfinite(self.over_s):
            self.end(self.over_s)  # what was before the end may be heard after it

    def _settle(self, robot: int, settled: RobotSettled, t_s: float) -> None:
        """A robot knows that the run is over."""
        self.settled[robot] = settled
        if self.is_resumed:
            self.end(t_s)

    def _strand(self, stranded: RobotStranded, t_s: float) -> None:
        """A robot is stranded; whose body is in the way a later view may not know."""
        before = self.stranded.get(stranded.robot, stranded)
        by = before.by if stranded.by is None else stranded.by
        self.stranded[stranded.robot] = replace(stranded, by=by)
        self.stranded_s = max(self.stranded_s, t_s)

    def _form(self, formed: StrandFormed, t_s: float) -> None:
        """A formation has been made: it takes in those that were stranded before, or says so again."""
        if formed.epoch > self._formed:
            self._formed, self.order, self.stranded_s = formed.epoch, formed.order, max(self.stranded_s, t_s)
            self.stranded = {
                robot: each for robot, each in self.stranded.items() if each.epoch >= formed.epoch
            }
            before, self._left_out = self._left_out, frozenset(self.stranded)
            again = self.arrived_s > 0.0 and bool(before) and before == self._left_out
            self.stranded_before_s = self._formed_s if again else -math.inf
            self._formed_s = t_s

    def stranded_among(self, living: Set[int]) -> list[int]:
        """Those of the living robots that are stranded and have not arrived."""
        return sorted((self.stranded.keys() - self.arrived) & living)

    @property
    def changed_s(self) -> float:
        """When a robot last arrived, was stranded or disturbed, or a formation was made."""
        return max(self.arrived_s, self.stranded_s, self.disturbed_s or 0.0)

    def _disturb(self, t_s: float) -> None:
        self.disturbed_s = max(self.disturbed_s or 0.0, t_s)
        self.stranded_before_s, self._left_out = -math.inf, frozenset()
