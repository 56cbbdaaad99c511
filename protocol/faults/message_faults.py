"""The effects of a fault plan on messages, decided at the receiver. Pure: time is an argument.

Rule 1: every draw is a hash of seed, rule, key, receiver and number. So a live run and a rehearsal make the
        same decisions, and other messages and their order have no influence.
Rule 2: rules decide in the order of the plan; a message that one rule removes is not seen by later rules.
Rule 3: a rule affects the recorder's messages only if it names their kind. Messages about faults are never
        affected.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from msgspec import Struct

from protocol.faults.chance import Chance, Draws, seed_of
from protocol.faults.damage import Damage
from protocol.faults.plan import Plan
from protocol.faults.rules import (
    ROUTER,
    Burst,
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    MessageRule,
    Partition,
    Reorder,
)
from protocol.keys import WORLD

LEFT_ALONE = ("log", "logged", "faults")


class Copy(Struct, frozen=True):
    """One arrival of a message: its delay and its damage."""

    delay_s: float = 0.0
    damage: Damage | None = None


class Injection(Struct, frozen=True):
    """One injection: the rule that struck, and its fault."""

    rule: str
    fault: str


class Effect(Struct, frozen=True):
    """The effect on a message: its arrivals, and the injections that caused them."""

    copies: tuple[Copy, ...] = (Copy(),)
    injections: tuple[Injection, ...] = ()

    @property
    def removed_by(self) -> str | None:
        """The fault that removes the message (it is lost) or makes it invalid (it will be refused)."""
        if not self.copies:
            return self.injections[-1].fault
        return "corrupt" if self.copies[0].damage is not None else None


NO_EFFECT = Effect()


@dataclass(slots=True)
class _Case:
    """A rule that may affect messages of one kind, on one key, at one receiver."""

    rule: MessageRule
    chance: Chance
    looked_at: tuple[int, bool] = (0, False)
    """The last message of which `_in_burst` was asked, and the answer: later ones need not look beyond it."""

    def strikes(self, number: int, draw: float) -> bool:
        """Whether the draw selects this message."""
        burst = self.rule.burst
        if burst is None:
            return draw < self.rule.probability
        return draw < burst.loss and self._in_burst(burst, number)

    def _in_burst(self, burst: Burst, number: int) -> bool:
        """Whether this message is in a burst: the newest message that began or ended one decides."""
        before, in_burst = self.looked_at if self.looked_at[0] <= number else (0, False)
        for earlier in range(number, before, -1):
            draw = self.chance.draws(earlier)[1]
            if draw < burst.enter or draw >= 1.0 - burst.leave:
                in_burst = draw < burst.enter
                break
        self.looked_at = number, in_burst
        return in_burst


class MessageFaults:
    """The effects of a plan on all messages of a run, or on those that one process receives."""

    def __init__(
        self, plan: Plan, seed: int, *, counted: Mapping[tuple[str, str, str], int] = MappingProxyType({})
    ) -> None:
        self._rules = tuple(rule for rule in plan.rules if isinstance(rule, MessageRule))
        self._cuts = tuple(rule for rule in self._rules if isinstance(rule, Partition) and _is_whole(rule))
        self.is_empty = not self._rules
        """Whether no rule can affect any message."""
        self.may_cut = len(self._cuts) > 0
        """Whether any rule can cut a process off from the router."""
        self._seed = seed
        self._cases: dict[tuple[str, str, str], tuple[_Case, ...]] = {}
        self._unnumbered = Counter(counted)

    def turned_to(self, plan: Plan) -> "MessageFaults":
        """The effects of another plan from now on, in the same run."""
        return MessageFaults(plan, self._seed, counted=self._unnumbered)

    def of(self, key: str, kind: str, number: int, receiver: str, *, now_s: float, step: int) -> Effect:
        """The effect on a message.

        Args:
            key: the key of the message, without the run's root.
            kind: its tag: `ahead`, `drive`, ...
            number: its number on that key; 0 for queries and replies, which are counted here.
            receiver: the process that received it: `r3`, `world`.
            now_s: simulated time.
            step: the newest switching step that is known to be planned.
        """
        if not (cases := self._cases_of(key, kind, receiver)):
            return NO_EFFECT
        place = (key, kind, receiver)
        if number == 0:
            self._unnumbered[place] += 1
            number = self._unnumbered[place]
        effect = NO_EFFECT
        for case in cases:
            if effect.copies and case.rule.holds(now_s, step):
                draws = case.chance.draws(number)
                if case.strikes(number, draws[0]):
                    effect = _apply(effect, case.rule, draws)
        return effect

    def cut_off(self, processes: Iterable[str], *, now_s: float, step: int) -> set[str]:
        """Those of the processes that are cut off from the router: they reach nobody, and show no token."""
        cuts = [rule for rule in self._cuts if rule.holds(now_s, step)]
        if not cuts:
            return set()
        return {
            each
            for each in processes
            if any(rule.cuts(each, ROUTER) or rule.cuts(ROUTER, each) for rule in cuts)
        }

    def is_cut(self, process: str, *, now_s: float, step: int) -> bool:
        """Whether a process is cut off from the router."""
        return len(self.cut_off([process], now_s=now_s, step=step)) > 0

    def hold_up(self, robot: str, *, now_s: float, step: int) -> bool:
        """Whether a rule that is active may delay or remove odometry of a robot, or its orders."""
        ways = ((f"body/{robot}/odometry", "odometry", robot), (f"body/{robot}/drive", "drive", WORLD))
        return any(case.rule.holds(now_s, step) for way in ways for case in self._cases_of(*way))

    def _cases_of(self, key: str, kind: str, receiver: str) -> tuple[_Case, ...]:
        """The rules that may ever affect such messages; they are looked for once."""
        place = (key, kind, receiver)
        if (cases := self._cases.get(place)) is None:
            cases = self._cases[place] = tuple(self._find_cases(*place))
        return cases

    def _find_cases(self, key: str, kind: str, receiver: str) -> Iterator[_Case]:
        sender = sender_of(key, receiver)
        for rule in self._rules:
            if _concerns(rule, kind, sender, receiver):
                yield _Case(rule, Chance(self._seed, str(rule.name), key, kind, receiver))


def sender_of(key: str, receiver: str) -> str:
    """The sender of messages on a key (without the run's root); empty where the key does not name it."""
    match key.split("/"):
        case ["link" | "view" | "log" | "alive", sender, *_] | ["body", "fence", sender]:
            return sender
        case ["body", robot, "drive" | "scan"] if receiver == WORLD:
            return robot
        case ["body" | "logged" | "mission", *_] if receiver != WORLD:
            return WORLD
        case _:
            return ""


def _concerns(rule: MessageRule, kind: str, sender: str, receiver: str) -> bool:
    """Whether a rule can affect such messages at any time."""
    if isinstance(rule, Partition):
        ways = ((sender, receiver), (sender, ROUTER), (ROUTER, receiver))
        if not any(rule.cuts(*way) for way in ways):
            return False
    return (
        (kind in rule.kinds if rule.kinds else kind not in LEFT_ALONE)
        and (not rule.sender or sender in rule.sender)
        and (not rule.receiver or receiver in rule.receiver)
    )


def _is_whole(rule: Partition) -> bool:
    """Whether the partition stops every message while it is active."""
    limits = (rule.sender, rule.receiver, rule.kinds, rule.burst)
    return rule.probability == 1.0 and not any(limits)


def _apply(effect: Effect, rule: MessageRule, draws: Draws) -> Effect:
    """The effect after this rule. Each draw has one purpose, so that draws stay independent."""
    copies = effect.copies
    match rule:
        case Drop() | Partition():
            copies = ()
        case Delay():
            later_s = rule.delay_s_min + draws[2] * (rule.delay_s_max - rule.delay_s_min)
            copies = _later(copies, later_s)
        case Reorder():
            copies = _later(copies, rule.hold_s)
        case Duplicate():
            spread = Chance(seed_of(draws[2]), "copies")
            more = (_later(copies[:1], rule.delay_s_max * spread.draws(n)[0]) for n in range(rule.copies))
            copies = (*copies, *(copy for each in more for copy in each))
        case Corrupt():
            damage = Damage(rule.bits, rule.truncate, seed=seed_of(draws[3]))
            copies = tuple(Copy(copy.delay_s, damage) for copy in copies)
    return Effect(copies, (*effect.injections, Injection(str(rule.name), rule.fault)))


def _later(copies: tuple[Copy, ...], delay_s: float) -> tuple[Copy, ...]:
    return tuple(Copy(copy.delay_s + delay_s, copy.damage) for copy in copies)
