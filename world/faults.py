"""The faults of a run as the world injects them: by the plan, and by hand while it runs. Pure.

Rule 1: a manual rule gets its window and its name here. One for messages can be ended by that name.
Rule 2: the world sends robots the whole state repeatedly, so one message that arrives is enough.
        A manual rule for a process is forgotten when it has struck and ended: a long run may have thousands.
Rule 3: a resumed world continues from the timeline of a world that was killed. It uses no rule name again.
        Its message numbers start beyond all that the killed world can have used, because robots keep the
        state with the greatest number.
"""

import re
from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from protocol.errors import UsageError
from protocol.faults.fit import misfits
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault, ProcessFaults
from protocol.faults.rules import GIVEN_MAX, MessageRule, ProcessRule, Restart, Rule, Thaw
from protocol.keys import WORLD, robot_name
from protocol.timeline import Entry, FaultInjected, RobotStarted, WorldResumed
from protocol.wire.codec import fits
from protocol.wire.messages import Faults

TELL_S = 0.5  # simulated: how often the state is repeated
NEWS_MAX = 2**32  # per life of the world: more than a run has ticks; 2 million lives fit into a `Count`
STOPS_OR_RESUMES = frozenset(
    [ProcessAction.KILL, ProcessAction.START, ProcessAction.FREEZE, ProcessAction.THAW]
)
GIVEN = re.compile(r"given-([0-9]{1,9})([.]|$)")  # bounded, since a robot may record any name


def is_given(name: str) -> bool:
    """Whether a rule of this name may be one that was given by hand."""
    return GIVEN.match(name) is not None


def _given_number(name: str) -> int:
    """The number in a name that a rule given by hand may have; 0: no such rule has it."""
    found = GIVEN.match(name)
    return 0 if found is None else int(found[1])


class RunFaults:
    """The faults of one run."""

    def __init__(self, plan: Plan, seed: int, *, robots: int) -> None:
        self._robots = robots
        self._planned = ProcessFaults(plan, seed)
        self._seed = seed
        self._manual: list[ProcessFaults] = []
        self._rules: tuple[Rule, ...] = ()
        self._struck: dict[str, None] = {}
        self._last_action: dict[str, str] = {}
        """The last action on each process that stopped it or had it go on."""
        self._slow_s: dict[str, float] = {}
        self._given = max(map(_given_number, plan.names), default=0)
        """The greatest number that a rule has, by hand or of the plan: names must differ (rule 1)."""
        self._news = 0
        self._told_news, self._told_s = 0, 0.0
        self._names = frozenset(plan.names)
        """Of the rules of the plan, which robots have, too."""

    def recall(self, source: str, _: str, entry: Entry) -> None:
        """Process an entry from before the world was started again."""
        self.hear(source, entry)
        match entry.record:
            case FaultInjected(fault="slow", rule=rule, process=str(process)):
                if (delay_s := self._planned.delay_s(rule)) > 0.0:
                    self._slow_s[process] = delay_s
            case FaultInjected(fault="unslow", process=str(process)):
                self._slow_s.pop(process, None)
            case _:
                pass

    def hear(self, source: str, entry: Entry) -> None:
        """Process a timeline entry."""
        step = self._planned.step
        for faults in (self._planned, *self._manual):
            faults.hear(source, entry)
        match entry.record:
            case FaultInjected() as injected:
                self._hear_injected(injected)
            case RobotStarted():
                self._last_action.pop(source, None)
            case WorldResumed():
                self._news += NEWS_MAX
            case _:
                pass
        if self._planned.step != step:
            self._news += 1

    def _hear_injected(self, injected: FaultInjected) -> None:
        rule, process = injected.rule, injected.process
        self._given = max(self._given, _given_number(rule))
        if process is None:
            return
        if injected.fault in STOPS_OR_RESUMES:
            self._last_action[process] = injected.fault
        if rule in self._names and rule not in self._struck:
            self._struck[rule] = None
            self._news += 1

    def due(self, now_s: float) -> list[ProcessFault]:
        """The process faults that are due by now."""
        faults = list(self._due(now_s))
        self._manual = [each for each in self._manual if not each.is_over]
        for fault in faults:
            if fault.action in {ProcessAction.SLOW, ProcessAction.UNSLOW}:
                self._slow_s[fault.process] = fault.delay_s
                self._news += 1
            elif (fault.process, fault.action) == (WORLD, ProcessAction.FREEZE):
                # The clock stands still meanwhile, so the world finds itself thawed at once.
                for each in (self._planned, *self._manual):
                    each.note_recovered(WORLD, now_s)
        return faults

    def _due(self, now_s: float) -> Iterator[ProcessFault]:
        """The faults of the plan, then of the manual rules; none strikes a robot killed by another."""
        for each in (self._planned, *self._manual):
            for fault in each.due(now_s):
                yield fault
                for other in (self._planned, *self._manual):
                    other.note_injected(fault)

    def add(self, rule: Rule, *, now_s: float, for_s: float | None) -> str:
        """Apply a rule from now on; returns its name.

        Raises:
            UsageError: the rule does not fit the fleet, or is not possible while a run is active.
        """
        name, rules = self.resolve(rule, now_s=now_s, for_s=for_s)
        if isinstance(rule, ProcessRule):
            plan = Plan(name=name, rules=rules)
            self._manual.append(ProcessFaults(plan, self._seed, frozen=self._planned.ended.frozen))
        else:
            kept = self._active(now_s)
            if len(kept) == GIVEN_MAX:
                raise UsageError(f"no more than {GIVEN_MAX} rules may be given at once")
            if not fits(((*kept, *rules), self._names)):
                raise UsageError("the rules that were given do not fit into one message; end some first")
            self._rules = (*kept, *rules)
            for each in (self._planned, *self._manual):
                each.expect(rules)
            self._news += 1
        self.take()
        return name

    def take(self) -> None:
        """The name that a rule was given now is used: the next one gets another."""
        self._given += 1

    def resolve(self, rule: Rule, *, now_s: float, for_s: float | None) -> tuple[str, tuple[Rule, ...]]:
        """The name that a rule would have now, and what it says in a plan: roles become robots.

        Raises:
            UsageError: as `add`.
        """
        for misfit in misfits(rule, robots=self._robots):
            raise UsageError(f"fault {rule.fault}: ${misfit}")
        name = f"given-{self._given + 1}"
        if isinstance(rule, MessageRule):
            until_s = None if for_s is None else now_s + for_s
            return name, (replace(rule, name=name, from_s=now_s, until_s=until_s),)
        if rule.point is not None:
            raise UsageError(
                "only a plan that a robot has from its start can strike it at a point of its step"
            )
        found = self._planned.roles.find(rule.target, rule.robots)
        if len(found) < rule.robots:
            raise UsageError(f"nobody is {rule.target} yet, or fewer than {rule.robots} stand from there on")
        for each in found:
            self._check(rule, each)
        named = (replace(rule, name=f"{name}.{each}", target=each, robots=1) for each in found)
        return name, tuple(replace(each, from_s=max(each.from_s, now_s)) for each in named)

    def end(self, name: str, *, now_s: float) -> None:
        """End a rule for messages that was given.

        Raises:
            UsageError: there is none, or its time is over.
        """
        if name not in {each.name for each in self._active(now_s)}:
            raise UsageError(f"no rule {name} for messages is active")
        self._rules = tuple(each for each in self._rules if each.name != name)
        self._news += 1

    def _active(self, now_s: float) -> list[Rule]:
        """The rules for messages whose time is not over; one may wait for a step, or pause."""
        return [each for each in self._rules if each.until_s is None or now_s < each.until_s]

    def _check(self, rule: ProcessRule, process: str) -> None:
        """Refuse a rule that cannot affect a process: a dead process can only be restarted."""
        if process in self._planned.ended and not isinstance(rule, Restart):
            raise UsageError(f"{process} is dead; a restart starts it again")
        if isinstance(rule, Thaw) and process not in self._planned.ended.frozen:
            raise UsageError(f"{process} is not frozen")

    def hold_up(self, process: str) -> bool:
        """Whether a process fault keeps a process from answering in time."""
        stopped = self._last_action.get(process) in (ProcessAction.KILL, ProcessAction.FREEZE)
        return stopped or self._slow_s.get(process, 0.0) > 0.0

    def of(self, process: str) -> Faults:
        """The state of faults to send to a process."""
        return Faults(
            number=self._news + 1,
            step=self._planned.step,
            struck=tuple(self._struck),
            rules=self._rules,
            slow_s=self._slow_s.get(process, 0.0),
        )

    def news(self, robots: Sequence[int], now_s: float) -> dict[str, Faults]:
        """The state to send to each robot now; empty if nothing is new, or there are no faults."""
        if not (self._names or self._given):
            return {}
        if self._news == self._told_news and now_s - self._told_s < TELL_S:
            return {}
        self._told_news, self._told_s = self._news, now_s
        return {name: self.of(name) for name in map(robot_name, robots)}
