"""The process faults of a plan, and when each is due. Pure: time and timeline entries in, faults out.

Rule 1: each rule strikes once: when its window is open, its target exists, and its point is reached.
Rule 2: a robot's own process is the first to know the points of its step. So it asks for the faults at points
        itself (`at_points`), and injects them. Later parts of the same fault, such as a thaw, are `due` at
        the process that reads the timeline. A robot knows only its own entries, so it is told which rules
        have struck, and the newest switching step (`catch_up`).
Rule 3: a process that a rule has killed and not restarted has no role.
Rule 4: no rule strikes a dead robot, for any cause of death: it waits until the robot is alive (`ended`).
        Nor does a thaw strike a process that is not frozen.
Rule 5: a world that is started again learns from the timeline what has been injected: no part of a fault is
        injected twice, and none that was still to come is forgotten.
"""

import heapq
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import assert_never

from protocol.faults.chance import draws
from protocol.faults.ended import Ended
from protocol.faults.plan import Plan
from protocol.faults.roles import Roles
from protocol.faults.rules import Freeze, Kill, ProcessRule, Restart, Rule, Slow, StepPoint, Thaw
from protocol.keys import WORLD
from protocol.timeline import Entry, FaultInjected, RobotStarted, WorldResumed


class ProcessAction(StrEnum):
    """The actions on a process."""

    KILL = "kill"
    START = "start"
    FREEZE = "freeze"
    THAW = "thaw"
    SLOW = "slow"
    UNSLOW = "unslow"


ENDS = frozenset({ProcessAction.START, ProcessAction.THAW, ProcessAction.UNSLOW})
"""The actions that end a fault."""


@dataclass(frozen=True, slots=True)
class ProcessFault:
    """One action on one process, due now. The process that injects it records `fault.injected`."""

    rule: str
    action: ProcessAction
    process: str
    delay_s: float = 0.0
    """Of `slow`: the delay of each read of the inbox."""
    for_s: float | None = None
    """The time until another fault undoes it; None: unknown, or never."""

    @property
    def part(self) -> tuple[str, str, str]:
        """What its entry says: each part of a fault is injected once."""
        return self.rule, str(self.action), self.process

    def as_record(self) -> FaultInjected:
        """Its entry in the timeline."""
        return FaultInjected(fault=str(self.action), rule=self.rule, process=self.process)


class ProcessFaults:
    """The process rules of a plan, and which of them have struck."""

    def __init__(self, plan: Plan, seed: int, *, frozen: Iterable[str] = ()) -> None:
        """The rules of a plan; `frozen` are the processes that others have frozen before."""
        rules = [rule for rule in plan.rules if isinstance(rule, ProcessRule)]
        self._seed = seed
        self._rules = {str(rule.name): rule for rule in rules}
        self._pending = {str(rule.name): rule for rule in rules if _comes_true(rule, seed)}
        self.has_points = any(rule.point is not None for rule in self._pending.values())
        """Whether any rule strikes at a point of a robot's step."""
        self.roles = Roles()
        """Which robots lead and coordinate, by the timeline."""
        self._down: set[str] = set()
        self.ended = Ended(plan.rules, frozen)
        """Which robots have no process, and what is frozen."""
        self._later: list[tuple[float, int, ProcessFault]] = []
        self._count = 0  # breaks ties, so that faults due together keep their order
        self._reached: Counter[tuple[str, str]] = Counter()  # by rule and robot
        self.step = 0
        """The newest switching step that is known to be planned."""

    def turn_to(self, plan: Plan) -> None:
        """Use this plan from now on; a rule that has struck does not strike again under the same name."""
        rules = {str(rule.name): rule for rule in plan.rules if isinstance(rule, ProcessRule)}
        self._pending = {
            name: rule
            for name, rule in rules.items()
            if name in self._pending or (name not in self._rules and _comes_true(rule, self._seed))
        }
        self._rules |= rules
        self.has_points |= any(rule.point is not None for rule in self._pending.values())
        self.ended.expect(plan.rules)

    def delay_s(self, rule: str) -> float:
        """The delay of the rule with this name; 0: it slows nothing."""
        known = self._rules.get(rule)
        return known.delay_s if isinstance(known, Slow) else 0.0

    @property
    def is_over(self) -> bool:
        """Whether no fault is left that could become due."""
        return not (self._pending or self._later)

    def catch_up(self, struck: Iterable[str], step: int) -> None:
        """Learn which rules have struck elsewhere, and the newest switching step."""
        self.step = max(self.step, step)
        for rule in struck:
            self._pending.pop(rule, None)

    def hear(self, source: str, entry: Entry) -> None:
        """Process a timeline entry."""
        self.roles.hear(source, entry)
        self.step = max(self.step, self.roles.step)
        self.ended.hear(source, entry)
        match entry.record:
            case FaultInjected(rule=rule, fault=action, process=str(process)) if rule in self._rules:
                self._hear_injected(self._rules[rule], action, process, entry.t_s)
            case WorldResumed():
                self.note_recovered(WORLD, entry.t_s)  # the clock stood still while the world was away
            case RobotStarted():
                self._reached = Counter({at: n for at, n in self._reached.items() if at[1] != source})
            case _:
                pass

    def _hear_injected(self, rule: ProcessRule, action: str, process: str, t_s: float) -> None:
        """Rule 5; what was injected here is known already, and changes nothing."""
        self._pending.pop(str(rule.name), None)
        if action not in ENDS:
            self._begin(rule, process, t_s)
            return
        ended = str(rule.name), action, process
        for each in [each for each in self._later if each[2].part == ended]:
            self._later.remove(each)
            if action == ProcessAction.START:
                self._down.discard(process)
        heapq.heapify(self._later)

    def due(self, now_s: float) -> list[ProcessFault]:
        """The faults that are due by now, each once, in order; without those at points of a step."""
        faults: list[ProcessFault] = []
        while self._later and self._later[0][0] <= now_s:
            faults.append(fault := heapq.heappop(self._later)[2])
            if fault.action is ProcessAction.START:
                self._down.discard(fault.process)
            self.ended.note_action(fault.process, fault.action)
        for rule in [rule for rule in self._pending.values() if rule.point is None]:
            if rule.holds(now_s, self.step) and (found := self._find(rule)):
                faults += self._strike(rule, found, now_s)
        return faults

    def at_points(self, robot: str, points: Sequence[StepPoint], now_s: float) -> list[ProcessFault]:
        """The faults for this robot, which is at these points of its step now."""
        faults: list[ProcessFault] = []
        for rule in [rule for rule in self._pending.values() if rule.point in points]:
            if rule.holds(now_s, self.step) and self._find(rule) == (robot,):
                self._reached[str(rule.name), robot] += 1
                if self._reached[str(rule.name), robot] == rule.occurrence:
                    faults += self._strike(rule, (robot,), now_s)
        return faults

    def expect(self, rules: Iterable[Rule]) -> None:
        """Take further rules into account: a robot that a partition has cut off is not dead."""
        self.ended.expect(rules)

    def note_injected(self, fault: ProcessFault) -> None:
        """Note a fault that is injected now, here or elsewhere; its record follows."""
        self.ended.note_action(fault.process, fault.action)

    def note_recovered(self, process: str, now_s: float) -> None:
        """The fault of this process has been ended elsewhere: its remaining parts are due now."""
        self._later = [
            (min(due_s, now_s) if fault.process == process else due_s, count, fault)
            for due_s, count, fault in self._later
        ]
        heapq.heapify(self._later)

    def _find(self, rule: ProcessRule) -> tuple[str, ...]:
        """The rule's targets; empty while it has to wait for one of them."""
        found = self.roles.find(rule.target, rule.robots)
        waits = any(each in self._down or each in self.ended for each in found) or len(found) < rule.robots
        if isinstance(rule, Thaw):
            waits = waits or not self.ended.frozen.issuperset(found)
        return () if waits else found

    def _strike(self, rule: ProcessRule, processes: Sequence[str], now_s: float) -> list[ProcessFault]:
        """The rule's first faults; what follows of them is kept until it is due."""
        del self._pending[str(rule.name)]
        return [self._begin(rule, process, now_s) for process in processes]

    def _begin(self, rule: ProcessRule, process: str, now_s: float) -> ProcessFault:
        """A rule's first fault of one process; what follows of it is kept until it is due."""
        name = str(rule.name)
        match rule:
            case Kill():
                fault = ProcessFault(name, ProcessAction.KILL, process)
            case Restart(after_s=after_s):
                fault = ProcessFault(name, ProcessAction.KILL, process, for_s=after_s)
                self._keep(now_s + after_s, ProcessFault(name, ProcessAction.START, process))
            case Freeze(for_s=for_s):
                fault = ProcessFault(name, ProcessAction.FREEZE, process, for_s=for_s)
                if for_s is not None:
                    self._keep(now_s + for_s, ProcessFault(name, ProcessAction.THAW, process))
            case Thaw():
                fault = ProcessFault(name, ProcessAction.THAW, process)
            case Slow(delay_s=delay_s, for_s=for_s):
                fault = ProcessFault(name, ProcessAction.SLOW, process, delay_s)
                if for_s is not None:
                    self._keep(now_s + for_s, ProcessFault(name, ProcessAction.UNSLOW, process))
            case _:
                assert_never(rule)
        if fault.action is ProcessAction.KILL:
            self._down.add(process)
        self.ended.note_action(process, fault.action)
        return fault

    def _keep(self, due_s: float, fault: ProcessFault) -> None:
        if all(kept.part != fault.part for _, _, kept in self._later):
            self._count += 1
            heapq.heappush(self._later, (due_s, self._count, fault))


def _comes_true(rule: ProcessRule, seed: int) -> bool:
    return draws(seed, str(rule.name), rule.target)[0] < rule.probability
