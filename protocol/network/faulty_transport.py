"""A transport with fault injection: it applies a fault plan to everything that arrives.

Rule 1: faults are injected at the receiver, so a fault of one process or one link affects only that one.
Rule 2: each injection is recorded with the message's key and number, and counted, so the books balance.
Rule 3: delays are in simulated time; in lock-step, where the clock waits for messages, in wall-clock time.
Rule 4: a process that is cut off from the router shows no token and sees none, as if the router had lost it.
Rule 5: messages about faults are never affected.
Rule 6: rules are active by the newest odometry time that has arrived, even in a message that was removed.
        Otherwise a rule that removes odometry would never end. Time stamps of injections use the same clock,
        so no injection is recorded before its rule is active.
"""

import heapq
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf

from protocol.errors import MessageRefusedError
from protocol.faults.damage import Damage
from protocol.faults.message_faults import NO_EFFECT, Effect, MessageFaults
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.rules import Rule
from protocol.keys import Keys, matches
from protocol.network.around import AroundTransport
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Listed, Refused, Transport, Vanished
from protocol.timeline import FaultInjected
from protocol.wire.codec import decode, encode
from protocol.wire.messages import Faults, Message, Odometry


@dataclass(frozen=True, slots=True)
class Conditions:
    """The parameters of the faults of a run."""

    plan: Plan = NO_FAULTS
    seed: int = 1
    speed: float = 1.0
    """Simulated seconds per wall-clock second."""


class FaultyTransport(AroundTransport):
    """Another transport, with faults in what it receives."""

    def __init__(
        self,
        inner: Transport,
        conditions: Conditions,
        keys: Keys,
        name: str,
        note: Callable[[FaultInjected], None],
    ) -> None:
        super().__init__(inner)
        self.faults = Faults(number=0, step=0, struck=(), rules=(), slow_s=0.0)
        """The newest state of faults from the world; the world itself sets it."""
        self._conditions = conditions
        self._keys = keys
        self._name = name
        self._odometry_key = keys.odometry(name)
        self._note = note
        self.now_s = 0.0
        """The newest odometry time that has arrived (rule 6)."""
        self._message_faults = MessageFaults(conditions.plan, conditions.seed)
        self._due: list[tuple[float, int, Arrival]] = []
        self._held_count = 0  # breaks ties, so that arrivals due together keep their order
        self._slept_s = 0.0
        self._tokens: dict[str, bool] = {}
        """The existing tokens, and whether each is visible here."""

    def watch(self, patterns: Collection[str]) -> None:
        """Watch the tokens on these patterns from now on, and no others; `Listed` follows."""
        for key in [key for key in self._tokens if not any(matches(each, key) for each in patterns)]:
            del self._tokens[key]
        self._inner.watch(patterns)

    @property
    def busy_s(self) -> float:
        """How long this thread has computed, or was slowed down by a fault: the machine is not late then."""
        return time.thread_time() + self._slept_s

    def hold_up(self, robot: str) -> bool:
        """Whether a fault rule may now delay or remove what a robot hears of its body, or tells it."""
        return self._message_faults.hold_up(robot, now_s=self.now_s, step=self.faults.step)

    def tell_time(self, now_s: float) -> None:
        """Set the time of the run; a robot's transport reads it from the odometry."""
        self.now_s = max(self.now_s, now_s)

    def have(self, faults: Faults) -> None:
        """Apply these faults from now on, in addition to the plan's."""
        if faults.number <= self.faults.number:
            return
        if faults.rules != self.faults.rules:
            rules: tuple[Rule, ...] = (*self._conditions.plan.rules, *faults.rules)
            self._message_faults = self._message_faults.turned_to(Plan(name="given", rules=rules))
        self.faults = faults

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        """Wait for arrivals and return all of them; empty after the timeout."""
        until_s = inf if timeout_s is None else time.monotonic() + timeout_s
        while True:
            next_s = min(until_s, self._due[0][0] if self._due else inf)
            wait_s = None if next_s == inf else max(0.0, next_s - time.monotonic())
            raw = await self._inner.arrivals(wait_s)
            if self.faults.slow_s > 0.0:
                self._take_time()
            affected: list[Arrival] = []
            listed: list[Arrival] = []
            for arrival in raw:
                if isinstance(arrival, Listed):
                    listed.append(arrival)
                else:
                    affected += self._affect(arrival)
            if self._due:
                affected += self._released()
            if self._message_faults.may_cut or not all(self._tokens.values()):
                affected += self._look_at_tokens()
            affected += listed
            if affected or time.monotonic() >= until_s:
                return affected

    def _take_time(self) -> None:
        """The fault `slow` holds this process up."""
        slow_s = self.faults.slow_s / self._conditions.speed
        time.sleep(slow_s)
        self._slept_s += slow_s

    def _affect(self, arrival: Arrival) -> Iterable[Arrival]:
        """The arrivals that follow at once; delayed ones are kept until they are due."""
        match arrival:
            case Heard():
                return self._affect_message(arrival)
            case Asked(key, message):
                effect = self._effect(key, message, 0)
                # A query is answered once, even if a fault duplicates it.
                return self._apply(arrival, message, Effect(effect.copies[:1], effect.injections))
            case Appeared(key):
                self._tokens.setdefault(key, False)
            case Vanished(key):
                return (arrival,) if self._tokens.pop(key, False) else ()
            case Refused() | Listed():
                return (arrival,)
        return ()

    def _affect_message(self, heard: Heard) -> Iterable[Arrival]:
        key, message = heard.key, heard.message
        if isinstance(message, Faults):
            if key == self._keys.fault(self._name):
                self.have(message)
            return ()
        if isinstance(message, Odometry) and key == self._odometry_key:
            self.tell_time(message.t_s)
        if self._message_faults.is_empty:
            return (heard,)
        return self._apply(heard, message, self._effect(key, message, heard.number))

    def _effect(self, key: str, message: Message, number: int) -> Effect:
        if self._message_faults.is_empty:
            return NO_EFFECT
        behind_root, kind = self._keys.behind_root(key), str(type(message).__struct_config__.tag)
        step = self.faults.step
        effect = self._message_faults.of(behind_root, kind, number, self._name, now_s=self.now_s, step=step)
        for injected in effect.injections:
            self._note(
                FaultInjected(fault=injected.fault, rule=injected.rule, key=behind_root, number=number)
            )
        if number > 0 and effect.removed_by is not None:
            self.traffic.move_to_removed(key, number, effect.removed_by)
        return effect

    def _apply(self, arrival: Heard | Asked, message: Message, effect: Effect) -> Iterator[Arrival]:
        for copy in effect.copies:
            each = arrival if copy.damage is None else _damaged(arrival, message, copy.damage)
            if copy.delay_s <= 0.0:
                yield each
                continue
            self._held_count += 1
            due_s = time.monotonic() + copy.delay_s / self._conditions.speed
            heapq.heappush(self._due, (due_s, self._held_count, each))

    def _released(self) -> Iterator[Arrival]:
        now_s = time.monotonic()
        while self._due and self._due[0][0] <= now_s:
            yield heapq.heappop(self._due)[2]

    def _look_at_tokens(self) -> Iterator[Arrival]:
        """Rule 4."""
        may_cut = self._message_faults.may_cut  # if not, many tokens that come are not looked at one by one
        deaf = may_cut and self._is_cut(self._name)
        for key, seen in self._tokens.items():
            visible = not deaf and not (may_cut and self._is_cut(self._keys.part(key, 1)))
            if visible is not seen:
                self._tokens[key] = visible
                yield Appeared(key) if visible else Vanished(key)

    def _is_cut(self, process: str) -> bool:
        return self._message_faults.is_cut(process, now_s=self.now_s, step=self.faults.step)


def _damaged(arrival: Heard | Asked, message: Message, damage: Damage) -> Arrival:
    """The result of decoding the message's damaged bytes."""
    number = arrival.number if isinstance(arrival, Heard) else 0
    try:
        number, message = decode(damage.apply(encode(message, number)))
    except MessageRefusedError as error:
        return Refused(arrival.key, str(error))
    if isinstance(arrival, Heard):
        return Heard(arrival.key, number, message)
    return Asked(arrival.key, message, arrival.answer)
