"""What a fault plan does to messages, asked where they are received. Pure: time is an argument.

Rule 1: every draw is a hash of seed, rule, key, receiver and number. So a live run and a rehearsal decide
        alike, and a message more or less elsewhere, or in another order, changes nothing.
Rule 2: rules decide in the order of the plan; what one has taken away no other sees.
Rule 3: the recorder's messages are left alone unless a rule names their kind; what tells of faults always is.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

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
    """One arrival of a message: how much later, and with what damage."""

    delay_s: float = 0.0
    damage: Damage | None = None


class Injected(Struct, frozen=True):
    """A rule has struck."""

    rule: str
    fault: str


class Fate(Struct, frozen=True):
    """What becomes of a message: its arrivals, and who did it."""

    copies: tuple[Copy, ...] = (Copy(),)
    injected: tuple[Injected, ...] = ()

    @property
    def taken_away(self) -> str | None:
        """The fault that leaves nothing lawful of the message: it is lost, or will be refused."""
        if not self.copies:
            return self.injected[-1].fault
        return "corrupt" if self.copies[0].damage is not None else None


UNTOUCHED = Fate()


@dataclass(slots=True)
class _Case:
    """A rule that may strike messages of one kind, on one key, at one receiver."""

    rule: MessageRule
    chance: Chance

    def strikes(self, number: int, draw: float) -> bool:
        """Whether chance has it that this message is struck."""
        burst = self.rule.burst
        if burst is None:
            return draw < self.rule.probability
        return draw < burst.loss and self._in_burst(burst, number)

    def _in_burst(self, burst: Burst, number: int) -> bool:
        """The newest message that began or ended a burst, whatever went before, says whether it lasts."""
        for earlier in range(number, 0, -1):
            draw = self.chance.draws(earlier)[1]
            if draw < burst.enter:
                return True
            if draw >= 1.0 - burst.leave:
                return False
        return False


class Fates:
    """The fates of all messages of a run, or of those that one process receives."""

    def __init__(self, plan: Plan, seed: int) -> None:
        self._rules = tuple(rule for rule in plan.rules if isinstance(rule, MessageRule))
        self._cuts = tuple(rule for rule in self._rules if isinstance(rule, Partition) and _is_whole(rule))
        self._seed = seed
        self._cases: dict[tuple[str, str, str], tuple[_Case, ...]] = {}
        self._unnumbered: Counter[tuple[str, str, str]] = Counter()

    @property
    def may_cut(self) -> bool:
        """Whether a rule may ever cut a process off from the router."""
        return len(self._cuts) > 0

    def of(self, key: str, kind: str, number: int, receiver: str, *, now_s: float, step: int) -> Fate:
        """What becomes of a message.

        Args:
            key: that it came by, without the run's root.
            kind: its tag: `ahead`, `drive`, ...
            number: its number on that key; 0 for queries and answers, which are counted here.
            receiver: who has received it: `r3`, `world`.
            now_s: simulated time.
            step: the newest switching step that is known to have been planned.
        """
        place = (key, kind, receiver)
        if (cases := self._cases.get(place)) is None:
            cases = self._cases[place] = tuple(self._find_cases(*place))
        if not cases:
            return UNTOUCHED
        if number == 0:
            self._unnumbered[place] += 1
            number = self._unnumbered[place]
        fate = UNTOUCHED
        for case in cases:
            if fate.copies and case.rule.holds(now_s, step):
                draws = case.chance.draws(number)
                if case.strikes(number, draws[0]):
                    fate = _strike(fate, case.rule, draws)
        return fate

    def is_cut(self, process: str, *, now_s: float, step: int) -> bool:
        """Whether a process is cut off from the router, and so from everybody, and shows no token."""
        return any(
            rule.holds(now_s, step) and (rule.cuts(process, ROUTER) or rule.cuts(ROUTER, process))
            for rule in self._cuts
        )

    def _find_cases(self, key: str, kind: str, receiver: str) -> Iterator[_Case]:
        sender = sender_of(key, receiver)
        for rule in self._rules:
            if _concerns(rule, kind, sender, receiver):
                yield _Case(rule, Chance(self._seed, str(rule.name), key, kind, receiver))


def sender_of(key: str, receiver: str) -> str:
    """Who sent what came by a key, without the run's root; empty where the key does not say it."""
    match key.split("/"):
        case ["link" | "muster" | "log" | "alive", sender, *_]:
            return sender
        case ["body", robot, "drive" | "scan"] if receiver == WORLD:
            return robot
        case ["body" | "logged" | "mission", *_] if receiver != WORLD:
            return WORLD
        case _:
            return ""


def _concerns(rule: MessageRule, kind: str, sender: str, receiver: str) -> bool:
    """Whether a rule may strike such messages at all, as far as time does not matter."""
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
    """Whether nothing gets past it while it holds."""
    limits = (rule.sender, rule.receiver, rule.kinds, rule.burst)
    return rule.probability == 1.0 and not any(limits)


def _strike(fate: Fate, rule: MessageRule, draws: Draws) -> Fate:
    """What the rule makes of a fate; each draw has one purpose, so that they do not lean on each other."""
    copies = fate.copies
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
    return Fate(copies, (*fate.injected, Injected(str(rule.name), rule.fault)))


def _later(copies: tuple[Copy, ...], delay_s: float) -> tuple[Copy, ...]:
    return tuple(Copy(copy.delay_s + delay_s, copy.damage) for copy in copies)
