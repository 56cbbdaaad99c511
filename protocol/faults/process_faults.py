"""What a fault plan does to processes, and when. Pure: told the time and the timeline, it says what is due.

Rule 1: each rule strikes once: when its window is open, its target is there, and its point is reached.
Rule 2: points of a robot's step are known to its own process first, so they are asked for apart: live, by it
        (`at_points`). What follows, as a thaw, is `due` for whoever hears what it has recorded. Such a
        process hears nothing but its own entries, so it is told what else decides (`catch_up`).
Rule 3: a process that a rule has killed, and not started again, is nobody's leader, middle or tail.
"""

import heapq
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from protocol.faults.chance import draws
from protocol.faults.plan import Plan
from protocol.faults.roles import Roles
from protocol.faults.rules import Freeze, Kill, ProcessRule, Restart, Slow, StepPoint, Thaw
from protocol.keys import WORLD
from protocol.timeline import Entry, FaultInjected, RobotStarted, WorldResumed


class Blow(StrEnum):
    """What can be done to a process."""

    KILL = "kill"
    START = "start"
    FREEZE = "freeze"
    THAW = "thaw"
    SLOW = "slow"


@dataclass(frozen=True, slots=True)
class Stroke:
    """One thing to do to one process, now; whoever does it records it as `fault.injected`."""

    rule: str
    blow: Blow
    process: str
    delay_s: float = 0.0
    """Of `slow`: what the process takes each time that it looks at what has arrived; 0: it is as ever."""
    for_s: float | None = None
    """After so long another stroke undoes it; None: that is not known yet, or never."""

    def as_record(self) -> FaultInjected:
        """What the timeline says of it."""
        return FaultInjected(fault=str(self.blow), rule=self.rule, process=self.process)


class Strokes:
    """The process rules of a plan, and how far they are."""

    def __init__(self, plan: Plan, seed: int) -> None:
        rules = [rule for rule in plan.rules if isinstance(rule, ProcessRule)]
        self._pending = {str(rule.name): rule for rule in rules if _comes_true(rule, seed)}
        self.has_points = any(rule.point is not None for rule in self._pending.values())
        """Whether any rule strikes at a point of a robot's step."""
        self._roles = Roles()
        self._down: set[str] = set()
        self._later: list[tuple[float, int, Stroke]] = []
        self._count = 0  # breaks ties, so that strokes due together keep their order
        self._reached: Counter[tuple[str, str]] = Counter()  # by rule and robot
        self._told_step = 0

    @property
    def step(self) -> int:
        """The newest switching step that has been planned, as far as anybody has told."""
        return max(self._roles.step, self._told_step)

    def catch_up(self, struck: Iterable[str], step: int) -> None:
        """Take in what others know: which rules have struck, whomever, and the newest switching step."""
        self._told_step = max(self._told_step, step)
        for rule in struck:
            self._pending.pop(rule, None)

    def hear(self, source: str, entry: Entry) -> None:
        """Take a timeline entry in, as it comes."""
        self._roles.hear(source, entry)
        match entry.record:
            case FaultInjected(rule=rule, process=str(process)) if rule in self._pending:
                # A process has struck itself at a point of its step.
                self._strike(self._pending[rule], (process,), entry.t_s)
            case WorldResumed():
                self.is_back(WORLD, entry.t_s)  # its time has not gone on meanwhile
            case RobotStarted():
                self._reached = Counter({at: n for at, n in self._reached.items() if at[1] != source})
            case _:
                pass

    def due(self, now_s: float) -> list[Stroke]:
        """What is to be done by now, each once, in order; at points of a step nothing."""
        strokes: list[Stroke] = []
        while self._later and self._later[0][0] <= now_s:
            strokes.append(stroke := heapq.heappop(self._later)[2])
            if stroke.blow is Blow.START:
                self._down.discard(stroke.process)
        for rule in [rule for rule in self._pending.values() if rule.point is None]:
            if rule.holds(now_s, self.step) and (found := self._find(rule)):
                strokes += self._strike(rule, found, now_s)
        return strokes

    def at_points(self, robot: str, points: Sequence[StepPoint], now_s: float) -> list[Stroke]:
        """What is to be done to this robot, which is at these points of its step right now."""
        strokes: list[Stroke] = []
        for rule in [rule for rule in self._pending.values() if rule.point in points]:
            if rule.holds(now_s, self.step) and self._find(rule) == (robot,):
                self._reached[str(rule.name), robot] += 1
                if self._reached[str(rule.name), robot] == rule.occurrence:
                    strokes += self._strike(rule, (robot,), now_s)
        return strokes

    def is_back(self, process: str, now_s: float) -> None:
        """Whoever struck this process has undone it by himself: what was to undo it is due now."""
        self._later = [
            (min(due_s, now_s) if stroke.process == process else due_s, count, stroke)
            for due_s, count, stroke in self._later
        ]
        heapq.heapify(self._later)

    def _find(self, rule: ProcessRule) -> tuple[str, ...]:
        """The rule's targets; none while it has to wait for one of them."""
        found = self._roles.find(rule.target, rule.robots)
        waits = self._down.intersection(found) or len(found) < rule.robots
        return () if waits else found

    def _strike(self, rule: ProcessRule, processes: Sequence[str], now_s: float) -> list[Stroke]:
        """The rule's first strokes; what follows of them is kept until it is due."""
        name = str(rule.name)
        del self._pending[name]
        strokes: list[Stroke] = []
        for process in processes:
            match rule:
                case Kill():
                    self._down.add(process)
                    strokes.append(Stroke(name, Blow.KILL, process))
                case Restart(after_s=after_s):
                    self._down.add(process)
                    strokes.append(Stroke(name, Blow.KILL, process, for_s=after_s))
                    self._keep(now_s + after_s, Stroke(name, Blow.START, process))
                case Freeze(for_s=for_s):
                    strokes.append(Stroke(name, Blow.FREEZE, process, for_s=for_s))
                    if for_s is not None:
                        self._keep(now_s + for_s, Stroke(name, Blow.THAW, process))
                case Thaw():
                    strokes.append(Stroke(name, Blow.THAW, process))
                case Slow(delay_s=delay_s, for_s=for_s):
                    strokes.append(Stroke(name, Blow.SLOW, process, delay_s))
                    if for_s is not None:
                        self._keep(now_s + for_s, Stroke(name, Blow.SLOW, process))
        return strokes

    def _keep(self, due_s: float, stroke: Stroke) -> None:
        self._count += 1
        heapq.heappush(self._later, (due_s, self._count, stroke))


def _comes_true(rule: ProcessRule, seed: int) -> bool:
    return draws(seed, str(rule.name), rule.target)[0] < rule.probability
