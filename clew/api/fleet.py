"""A fleet that goes on, rehearsed or live, with one interface for both.

Rule 1: a fleet begins at the first wait. Faults that are given before are rules of its plan, and may strike
        at a point of a robot's step. Faults that are given later act from then on.
Rule 2: `until` looks at each entry once: it returns the first one after the entry that the last `until`
        returned, or after the newest fault. So nothing that happens between two waits is missed, and
        what happened before a fault is not taken for its effect.
Rule 3: limits of waiting are simulated seconds (`docs/testing.md` says what a live fleet adds to them).
"""

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self, Unpack

from msgspec.structs import replace

from clew.api import faults
from clew.api.entries import Entry
from clew.api.faults import When, Who
from clew.api.run import EndedRun, Run
from clew.log.timeline import Choice, unknown_kinds, unknown_step, unknown_wait
from protocol.errors import ClewError, UsageError
from protocol.faults.fit import misfits
from protocol.faults.plan import Plan
from protocol.faults.rules import MessageRule, ProcessRule, Rule
from protocol.keys import robot_name
from world.record.lines import Line
from world.scenario.scenario import Scenario

PLAN = "given"
END_S = 10.0  # simulated: after the time limit of a scenario, two phases of 2 s follow
TIMEOUT_S = 30.0  # simulated: a view after a death takes 5 s, a switching step of grove 4 s


class WaitFailedError(ClewError, AssertionError):
    """What was waited for did not happen: in a test, a failed assertion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """What was asked for."""

    scenario: Scenario
    seed: int
    folder: Path
    rules: tuple[Rule, ...] = ()
    without: frozenset[int] = frozenset()
    """Faults to leave out, by the count of when they were given; to find the ones that matter."""


@dataclass(frozen=True, slots=True)
class Given:
    """A fault that was given to a fleet."""

    fleet: "Fleet"
    name: str
    """In the timeline; empty: it was left out."""

    def end(self) -> None:
        """End a fault of messages now.

        Raises:
            UsageError: it is a rule of the plan, or does not act any more.
        """
        if self.name:
            self.fleet.end(self.name)


class Fleet(ABC):
    """A fleet: wait for what happens, give it faults, and get its run."""

    def __init__(self, asked: Asked) -> None:
        self.asked = asked
        self.has_begun = self._left = False
        self._planned: list[Rule] = []
        self._given: list[Rule] = []
        """As rules of a plan, with the times at which they were given and ended."""
        self._count = 0
        self._seen = 0
        """How many entries the waits have looked at."""
        for rule in asked.rules:
            self.inject(rule)

    # --- what a stage does --------------------------------------------------------------------------

    @property
    @abstractmethod
    def is_over(self) -> bool:
        """Whether the run has ended and is judged."""

    @property
    @abstractmethod
    def lines(self) -> Sequence[Line]:
        """All entries up to now."""

    @property
    @abstractmethod
    def now_s(self) -> float:
        """Simulated time."""

    @abstractmethod
    def _start(self, plan: Plan) -> None:
        """Start with this plan."""

    @abstractmethod
    def _advance(self) -> None:
        """Let something happen: a tick, or what comes within a moment."""

    @abstractmethod
    def _deadline(self, timeout_s: float) -> Callable[[], str | None]:
        """A deadline from now on [simulated s]: says in a sentence that it has passed; None: it has not."""

    @property
    @abstractmethod
    def _ending(self) -> str:
        """How the run ended, in words."""

    @abstractmethod
    def _give(self, rule: Rule) -> tuple[str, tuple[Rule, ...]]:
        """Give a fault now; returns its name, and what it is in a plan."""

    @abstractmethod
    def _end(self, name: str) -> None:
        """End a fault of messages."""

    @abstractmethod
    def close(self) -> None:
        """Stop, if the run goes on; nothing is left behind then, and the run has its verdict."""

    # --- waiting ------------------------------------------------------------------------------------

    def begin(self) -> Self:
        """Start, if it has not begun."""
        if self._left and not self.has_begun:
            raise UsageError("the fleet was ended before it began: nothing would end it now")
        if not self.has_begun:
            self.has_begun = True
            self._start(self.plan)
        return self

    def until(
        self,
        kind: str | tuple[str, ...],
        *,
        robot: int | str | None = None,
        step: int | None = None,
        where: Callable[[Entry], bool] | None = None,
        timeout_s: float = TIMEOUT_S,
    ) -> Entry:
        """Wait for the next entry of this kind. Each is looked at once; a fault skips what came before it.

        Args:
            kind: as `"step.planned"` or `"view.*"`, or several.
            robot: only from this robot, `3` or `"r3"`, or about it.
            step: only of this switching step.
            where: only where this is true.
            timeout_s: how long to wait [simulated s].

        Raises:
            UsageError: there is no such kind, robot or step, or nobody can wait so long.
            WaitFailedError: it did not come in time, or the run ended before.
        """
        __tracebackhide__ = True  # pytest then shows the line of the test, and not ours
        kinds = (kind,) if isinstance(kind, str) else kind
        if (unknown := unknown_kinds(kinds) or unknown_step(step) or unknown_wait(timeout_s)) is not None:
            raise UsageError(unknown)
        number = None if robot is None else faults.robot_of(robot, self.asked.scenario.fleet.robots)
        self.begin()
        choice, passed = Choice(kind=kinds, robot=number, step=step), self._deadline(timeout_s)
        while True:
            lines = self.lines
            while self._seen < len(lines):
                self._seen += 1
                entry = Entry(*lines[self._seen - 1])
                if choice.takes(entry.source, entry.written) and (where is None or where(entry)):
                    return entry
            why = passed()
            if self.is_over:
                why = f"the run ended at t={self.now_s:.1f} s: {self._ending}"
            if why is not None and self._seen == len(self.lines):
                raise WaitFailedError(f"{_said(kinds, number, step)} did not come: {why}")
            self._advance()

    def finish(self) -> EndedRun:
        """Let the run come to its own end; returns it.

        Raises:
            WaitFailedError: it does not end.
        """
        self.begin()
        passed = self._deadline(self.asked.scenario.time.time_s_max + END_S)
        while not self.is_over:
            if (why := passed()) is not None:
                raise WaitFailedError(f"the run did not end: {why}")
            self._advance()
        self._seen = len(self.lines)
        return EndedRun(self.asked.folder)

    @property
    def run(self) -> Run:
        """The run, as far as it has gone."""
        self.begin()
        return Run(self.asked.folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._left = True
        self.close()

    # --- faults -------------------------------------------------------------------------------------

    @property
    def plan(self) -> Plan:
        """All faults up to now as one plan, with which the run can be rehearsed."""
        return Plan(name=PLAN, rules=(*self._planned, *self._given))

    @property
    def given_count(self) -> int:
        """How many faults were given, those left out included."""
        return self._count

    def inject(self, rule: Rule) -> Given:
        """Give the fleet a fault: before it begins, a rule of its plan; later, one from now on.

        Raises:
            UsageError: it does not fit the fleet, has no effect, or cannot be given any more.
        """
        if not isinstance(rule, Rule):
            raise UsageError(f"inject: must be a rule, such as clew.drop(p=0.3), got {rule!r}")
        self._count += 1
        if self._count in self.asked.without:
            return Given(self, "")
        if not self.has_begun:
            # Without others it has the same name, and so the same random draws.
            rule = rule if rule.name is not None else replace(rule, name=f"{rule.fault}-{self._count}")
            for misfit in misfits(rule, robots=self.asked.scenario.fleet.robots):
                raise UsageError(f"clew.{rule.fault}: ${misfit}")
            if any(each.name == rule.name for each in self._planned):
                raise UsageError(f"clew.{rule.fault}: $.name: must be of one rule, got {rule.name} twice")
            self._planned.append(rule)
            return Given(self, str(rule.name))
        if self.is_over:
            raise UsageError(f"{rule.fault}: the run is over")
        window = (rule.from_s, rule.until_s, rule.from_step, rule.until_step) != (0.0, None, 0, None)
        if window or (isinstance(rule, ProcessRule) and rule.point is not None):
            raise UsageError(
                f"{rule.fault}: windows and points are for plans: give it before the fleet begins, which is "
                "at the first wait"
            )
        name, rules = self._give(rule)
        self._given += rules
        self._seen = len(self.lines)
        return Given(self, name)

    def end(self, name: str) -> None:
        """End a fault of messages that was given while the fleet went on.

        Raises:
            UsageError: no such fault acts.
        """
        if name in {rule.name for rule in self._planned}:
            raise UsageError(f"{name} is a rule of the plan: say there until when it acts")
        if self.is_over:
            return  # nothing acts any more
        if not any(rule.name == name and acts(rule) for rule in self._given):
            raise UsageError(f"no rule {name} for messages is active")
        self._end(name)
        self._given = [ended(rule, self.now_s) if rule.name == name else rule for rule in self._given]
        self._seen = len(self.lines)

    @contextlib.contextmanager
    def partition(self, group: Who, others: Who = (), *, one_way: bool = False) -> Iterator[Given]:
        """Cut two groups off from each other while the block lasts; without `others`, from all the rest."""
        self.begin()
        given = self.inject(faults.partition(group, others, one_way=one_way))
        try:
            yield given
        finally:
            given.end()

    def link(self, one: int | str, other: int | str, *, one_way: bool = False) -> "Link":
        """The link between two robots; `one_way`: only from the first to the second."""
        return Link(self, *faults.ends_of(one, other), one_way)

    def robot(self, robot: int | str) -> "Target":
        """The process of a robot, `3` or `"r3"`."""
        return Target(self, robot_name(faults.robot_of(robot, self.asked.scenario.fleet.robots)))

    @property
    def leader(self) -> "Target":
        """The leader: when the fault strikes or, once the fleet has begun, when it is given."""
        return Target(self, "leader")

    @property
    def middle(self) -> "Target":
        """The robot in the middle of the strand, at the same time as for `leader`."""
        return Target(self, "middle")

    @property
    def tail(self) -> "Target":
        """The last robot of the strand, at the same time as for `leader`."""
        return Target(self, "tail")

    @property
    def coordinator(self) -> "Target":
        """The robot that coordinates the view, at the same time as for `leader`."""
        return Target(self, "coordinator")

    @property
    def world(self) -> "Target":
        """The world's process."""
        return Target(self, "world")

    @property
    def router(self) -> "Target":
        """The router."""
        return Target(self, "router")


@dataclass(frozen=True, slots=True)
class Target:
    """A process of a fleet, to give faults to."""

    fleet: Fleet
    name: str

    def kill(self, *, at: str | None = None, occurrence: int = 1, **when: Unpack[When]) -> Given:
        """SIGKILL: now, or when the window opens and the robot reaches this point of its step."""
        return self.fleet.inject(faults.kill(self.name, at=at, occurrence=occurrence, **when))

    def freeze(self, *, for_s: float | None = None, at: str | None = None, **when: Unpack[When]) -> Given:
        """SIGSTOP, and after `for_s` SIGCONT."""
        return self.fleet.inject(faults.freeze(self.name, for_s=for_s, at=at, **when))

    def thaw(self, **when: Unpack[When]) -> Given:
        """SIGCONT."""
        return self.fleet.inject(faults.thaw(self.name, **when))

    def restart(self, *, after_s: float = 0.0, at: str | None = None, **when: Unpack[When]) -> Given:
        """SIGKILL, and after this time a new process."""
        return self.fleet.inject(faults.restart(self.name, after_s=after_s, at=at, **when))

    def slow(self, *, by_s: float, for_s: float | None = None, **when: Unpack[When]) -> Given:
        """It reacts so much later to everything."""
        return self.fleet.inject(faults.slow(self.name, by_s=by_s, for_s=for_s, **when))


@dataclass(frozen=True, slots=True)
class Link:
    """The link between two robots, to give faults to."""

    fleet: Fleet
    one: str
    other: str
    one_way: bool = False

    def drop(self, p: float = 1.0, *kinds: str, **when: Unpack[When]) -> Given:
        """Lose this share of its messages."""
        return self._inject(faults.drop(*kinds, p=p, **when))

    def delay(self, max_s: float, *kinds: str, min_s: float = 0.0, **when: Unpack[When]) -> Given:
        """Delay its messages, each by its own time."""
        return self._inject(faults.delay(*kinds, max_s=max_s, min_s=min_s, **when))

    def duplicate(self, copies: int = 1, *kinds: str, max_s: float = 0.0, **when: Unpack[When]) -> Given:
        """Repeat its messages."""
        return self._inject(faults.duplicate(*kinds, copies=copies, max_s=max_s, **when))

    def corrupt(self, p: float = 1.0, *kinds: str, bits: int = 1, **when: Unpack[When]) -> Given:
        """Damage this share of its messages."""
        return self._inject(faults.corrupt(*kinds, p=p, bits=bits, **when))

    def _inject(self, rule: Rule) -> Given:
        """Give a fault of messages to this link only."""
        ends = (self.one, self.other)
        sender, receiver = ((self.one,), (self.other,)) if self.one_way else (ends, ends)
        return self.fleet.inject(replace(rule, sender=sender, receiver=receiver))


def acts(rule: Rule) -> bool:
    """Whether a rule that was given is one for messages, and has not been ended."""
    return isinstance(rule, MessageRule) and rule.until_s is None and rule.probability > 0.0


def ended(rule: Rule, now_s: float) -> Rule:
    """The rule with its end; one that ended as it was given never acts."""
    return replace(rule, until_s=now_s) if now_s > rule.from_s else replace(rule, probability=0.0)


def _said(kinds: Sequence[str], robot: int | None, step: int | None) -> str:
    """What was waited for."""
    of_robot = "" if robot is None else f" of robot {robot}"
    of_step = "" if step is None else f" of step {step}"
    return f"{' or '.join(kinds)}{of_robot}{of_step}"
