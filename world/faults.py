"""What goes wrong in a run, as the world has it done: by a plan, and as is asked for while it runs. Pure.

Rule 1: a rule that is given while the run goes on has the window and the name that it gets here.
Rule 2: robots are told the whole state, again and again: one message that arrives is enough.
Rule 3: who goes on from the timeline of a world that was killed names no rule as one of those was named, and
        numbers what it tells beyond all that those can have told: robots take the greatest for the newest.
"""

import re
from collections.abc import Sequence

from msgspec.structs import replace

from protocol.errors import UsageError
from protocol.faults.fit import misfits
from protocol.faults.plan import Plan
from protocol.faults.process_faults import Blow, Stroke, Strokes
from protocol.faults.roles import Roles
from protocol.faults.rules import MessageRule, ProcessRule, Restart, Rule, Thaw
from protocol.keys import WORLD, robot_name, robot_number
from protocol.timeline import Entry, FaultInjected, RobotStarted, WorldResumed
from protocol.wire.messages import Faults

TELL_S = 0.5  # simulated: how often robots are told anyway
GIVEN_MAX = 100  # what a `Faults` may hold
NEWS_MAX = 2**32  # of one life of the world: more than a run has ticks, and 2 million lives are a `Count`
GIVEN = re.compile(r"given-(\d+)")


class Mischief:
    """The faults of one run."""

    def __init__(self, plan: Plan, seed: int, *, robots: int) -> None:
        self._robots = robots
        self._strokes = Strokes(plan, seed)
        self._seed = seed
        self._roles = Roles()
        self._by_hand: list[Strokes] = []
        self._rules: tuple[Rule, ...] = ()
        self._struck: dict[str, None] = {}
        self._blows: dict[str, str] = {}
        """What was done to a process last, of what stops it or has it go on."""
        self._slow_s: dict[str, float] = {}
        self._given = 0
        self._news = 0
        self._told_news, self._told_s = 0, 0.0
        self._is_planned = bool(plan.rules)

    def hear(self, source: str, entry: Entry) -> None:
        """Take a timeline entry in."""
        step = self._strokes.step
        self._roles.hear(source, entry)
        for strokes in (self._strokes, *self._by_hand):
            strokes.hear(source, entry)
        match entry.record:
            case FaultInjected(rule=rule) if given := GIVEN.match(rule):
                self._given = max(self._given, int(given[1]))
            case WorldResumed():
                self._news += NEWS_MAX
            case _:
                pass
        match entry.record:
            case FaultInjected(fault="kill" | "start" | "freeze" | "thaw" as blow, process=str(process)):
                self._blows[process] = blow
            case RobotStarted():
                self._blows.pop(source, None)
            case _:
                pass
        match entry.record:
            case FaultInjected(rule=rule, process=str()) if rule not in self._struck:
                self._struck[rule] = None
                self._news += 1
            case _ if self._strokes.step != step:
                self._news += 1
            case _:
                pass

    def due(self, now_s: float) -> list[Stroke]:
        """What is to be done to processes by now."""
        strokes = [stroke for each in (self._strokes, *self._by_hand) for stroke in each.due(now_s)]
        for stroke in strokes:
            if stroke.blow is Blow.SLOW:
                self._slow_s[stroke.process] = stroke.delay_s
                self._news += 1
            elif (stroke.process, stroke.blow) == (WORLD, Blow.FREEZE):
                for each in (self._strokes, *self._by_hand):
                    each.is_back(WORLD, now_s)  # its time stands still, so it finds itself thawed at once
        return strokes

    def give(self, rule: Rule, *, now_s: float, for_s: float | None) -> str:
        """A rule that holds from now on; returns its name.

        Raises:
            UsageError: it does not fit the fleet, or cannot be given while a run goes on.
        """
        for misfit in misfits(rule, robots=self._robots):
            raise UsageError(f"fault {rule.fault}: ${misfit}")
        self._given += 1
        name = f"given-{self._given}"
        if isinstance(rule, ProcessRule):
            self._by_hand.append(self._strokes_of(rule, name))
        elif isinstance(rule, MessageRule):
            until_s = None if for_s is None else now_s + for_s
            rule = replace(rule, name=name, from_s=now_s, until_s=until_s)
            kept = [each for each in self._rules if each.until_s is None or each.until_s > now_s]
            if len(kept) == GIVEN_MAX:
                raise UsageError(f"no more than {GIVEN_MAX} rules may be given at once")
            self._rules = (*kept, rule)
            self._news += 1
        return name

    def _strokes_of(self, rule: ProcessRule, name: str) -> Strokes:
        """A rule for whoever has that role now."""
        if rule.point is not None:
            raise UsageError(
                "only a plan that a robot has from its start can strike it at a point of its step"
            )
        found = self._roles.find(rule.target, rule.robots)
        if len(found) < rule.robots:
            raise UsageError(f"nobody is {rule.target} yet, or fewer than {rule.robots} stand from there on")
        for each in found:
            self._check(rule, each)
        rules = tuple(replace(rule, name=f"{name}.{each}", target=each, robots=1) for each in found)
        return Strokes(Plan(name=name, rules=rules), self._seed)

    def _check(self, rule: ProcessRule, process: str) -> None:
        """That something can be done to a process: who is dead cannot be struck, but started again."""
        blow = self._blows.get(process)
        if blow == Blow.KILL and robot_number(process) is not None and not isinstance(rule, Restart):
            raise UsageError(f"{process} is dead; restart has it start again")
        if isinstance(rule, Thaw) and blow != Blow.FREEZE:
            raise UsageError(f"{process} is not frozen")

    def of(self, process: str) -> Faults:
        """What a process is to know of faults."""
        return Faults(
            number=self._news + 1,
            step=self._strokes.step,
            struck=tuple(self._struck),
            rules=self._rules,
            slow_s=self._slow_s.get(process, 0.0),
        )

    def news(self, robots: Sequence[int], now_s: float) -> dict[str, Faults]:
        """What each robot is to be told now; nothing where it has been told, or nothing ever goes wrong."""
        if not (self._is_planned or self._given):
            return {}
        if self._news == self._told_news and now_s - self._told_s < TELL_S:
            return {}
        self._told_news, self._told_s = self._news, now_s
        return {name: self.of(name) for name in map(robot_name, robots)}
