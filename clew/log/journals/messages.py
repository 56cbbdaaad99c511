"""The messages of a run: those that robots took in, from their journals, and what became of others.

Rule 1: a robot's journal has what its core was given. Odometry that came with a newer one is not in it.
Rule 2: the world keeps no journal: of orders, puts and queries only those are known that a fault has struck
        or that were refused. What they said is in the journal of their sender.
Rule 3: one message has one line: an injection is told with the message that it struck. A refusal is one with
        the damage that led to it, or with the message that a core refused.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from agents.commands import Note
from clew.log.journals.contents import content, tag_of
from clew.log.journals.fate import Fate
from clew.log.journals.process import Process, command_of, message_in, sender_process
from clew.log.journals.recording import Turn
from protocol.faults.message_faults import sender_of
from protocol.timeline import FaultInjected, MessageRefused, StepPlanned
from protocol.wire.messages import Message as Sent
from world.record.lines import Line

FATES = {
    "drop": Fate.DROPPED,
    "partition": Fate.DROPPED,
    "delay": Fate.DELAYED,
    "reorder": Fate.DELAYED,
    "duplicate": Fate.DUPLICATED,
    "corrupt": Fate.DAMAGED,
}
"""What the faults of a plan make of a message; where several strike, the last in the order of `Fate`."""
_GRAVITY = list(Fate)
Place = tuple[str, str, int]
"""A receiver, a key, and a number on that key."""


@dataclass(frozen=True, slots=True, order=True)
class Message:
    """A message, at the process that received it or should have."""

    t_s: float
    """The receiver's time when it came, or when a fault took it."""
    sender: str
    receiver: str
    kind: str
    """As in fault plans, `ahead`; if no journal has the message, the family of its key: `link`."""
    key: str
    number: int
    """On that key; 0: it has none, or it was refused before it was read."""
    fate: Fate
    fault: str = ""
    """The faults that struck it: `drop`, `delay, duplicate`."""
    rule: str = ""
    """The rules that struck it."""
    reason: str = ""
    """Why it was refused."""
    message: Sent | None = field(default=None, compare=False, repr=False)
    """What it says; None: no journal has it."""

    @property
    def said(self) -> str:
        """Its content in short, or why it was refused."""
        said = "" if self.message is None else content(self.message)
        return f"{said}: {self.reason}" if said and self.reason else said or self.reason

    def as_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {**{name: getattr(self, name) for name in FIELDS}, "fate": str(self.fate), "said": self.said}


FIELDS = tuple(each.name for each in fields(Message) if each.compare)


@dataclass(frozen=True, slots=True)
class _Strike:
    """All that faults did to one message."""

    t_s: float
    faults: tuple[FaultInjected, ...]

    @property
    def fate(self) -> Fate:
        return max((FATES.get(each.fault, Fate.DELIVERED) for each in self.faults), key=_GRAVITY.index)

    @property
    def arrives(self) -> bool:
        return self.fate not in {Fate.DROPPED, Fate.DAMAGED}

    @property
    def told(self) -> tuple[Fate, str, str]:
        """Fate, faults and rules."""
        faults = dict.fromkeys(each.fault for each in self.faults)
        rules = dict.fromkeys(each.rule for each in self.faults)
        return self.fate, ", ".join(faults), ", ".join(rules)


class _Account:
    """What the log says of messages."""

    def __init__(self, lines: Iterable[Line]) -> None:
        self.strikes: dict[Place, list[_Strike]] = defaultdict(list)
        self.refusals: dict[tuple[str, str], list[tuple[float, MessageRefused]]] = defaultdict(list)
        for source, entry in lines:
            match entry.record:
                case FaultInjected(key=str(key), number=number) as fault:
                    self._note(self.strikes[source, key, number or 0], entry.t_s, fault)
                case MessageRefused(key=key) as refused:
                    self.refusals[source, key].append((entry.t_s, refused))
                case _:
                    pass  # of no message

    def _note(self, strikes: list[_Strike], t_s: float, fault: FaultInjected) -> None:
        """Several rules that strike one message note it at one time, each once."""
        if strikes and strikes[-1].t_s == t_s and fault not in strikes[-1].faults:
            strikes[-1] = _Strike(t_s, (*strikes[-1].faults, fault))
        else:
            strikes.append(_Strike(t_s, (fault,)))

    def refusal(self, receiver: str, key: str, reason: str | None = None) -> str | None:
        """Take the oldest refusal on this key, or the oldest with this reason; returns its reason."""
        left = self.refusals.get((receiver, key), [])
        for place, (_, refused) in enumerate(left):
            if reason in {None, refused.reason}:
                del left[place]
                return refused.reason
        return None


def messages_of(processes: list[Process], lines: Iterable[Line]) -> list[Message]:
    """All messages of a run with these processes and entries, by time."""
    account = _Account(lines)
    said = [*_delivered(processes, account), *_struck(processes, account), *_refused(account)]
    return sorted(said)


def _delivered(processes: Sequence[Process], account: _Account) -> Iterator[Message]:
    taken = set[tuple[Place, float]]()
    for process in processes:
        for turn in process.turns:
            if (message := message_in(turn.event)) is not None:
                yield _received(process, turn, message, account, taken)
    for place, strikes in account.strikes.items():
        strikes[:] = [each for each in strikes if (place, each.t_s) not in taken]


def _received(
    process: Process, turn: Turn, message: Sent, account: _Account, taken: set[tuple[Place, float]]
) -> Message:
    heard, receiver = turn.input, process.name
    place = (receiver, heard.key, heard.number)
    fate, fault, rule = Fate.DELIVERED, "", ""
    strikes = [each for each in account.strikes.get(place, ()) if each.arrives]
    if heard.number == 0:  # queries and their replies have no numbers: the oldest that is left
        strikes = [each for each in strikes if (place, each.t_s) not in taken][:1]
    if strikes:  # a sender that was started again counts anew
        strike = min(strikes, key=lambda each: abs(each.t_s - heard.now_s))
        taken.add((place, strike.t_s))
        fate, fault, rule = strike.told
    reason = _refusal_in(turn, heard.key)
    if reason is not None:
        account.refusal(receiver, heard.key, reason)
        fate = Fate.REFUSED
    sender, kind = sender_of(heard.key, receiver), tag_of(message)
    return Message(
        heard.now_s, sender, receiver, kind, heard.key, heard.number, fate, fault, rule, reason or "", message
    )


def _refusal_in(turn: Turn, key: str) -> str | None:
    """Why the core has refused the message of this turn, if it has."""
    for kind, given in () if turn.decision is None else turn.decision.commands:
        if kind == Note.__name__ and given["record"]["kind"] == "message.refused":
            command = command_of(kind, given)
            if isinstance(command, Note) and isinstance(refused := command.record, MessageRefused):
                return refused.reason if refused.key == key else None
    return None


def _struck(processes: list[Process], account: _Account) -> Iterator[Message]:
    """The messages that a fault has struck and that are in no journal of a receiver."""
    for (receiver, key, number), strikes in account.strikes.items():
        sender = sender_of(key, receiver)
        for strike in strikes:
            process = sender_process(processes, (key, number), strike.t_s, receiver=receiver)
            message = None if process is None else process.sent[key, number].message
            kind = _family(key) if message is None else tag_of(message)
            reason = account.refusal(receiver, key) if strike.fate is Fate.DAMAGED else None
            yield Message(
                strike.t_s, sender, receiver, kind, key, number, *strike.told, reason or "", message
            )


def _refused(account: _Account) -> Iterator[Message]:
    """The refused messages that no fault has damaged."""
    for (receiver, key), refusals in account.refusals.items():
        for t_s, refused in refusals:
            sender = sender_of(key, receiver)
            yield Message(t_s, sender, receiver, _family(key), key, 0, Fate.REFUSED, reason=refused.reason)


def _family(key: str) -> str:
    """The part of a key that tells its messages: `link`, `view`, or what of a body it is about."""
    parts = key.split("/")
    return parts[-1] if parts[0] == "body" and parts[1:2] != ["fence"] else parts[parts[0] == "body"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """Which messages to show; None or empty: all."""

    link: tuple[str, str] | None = None
    """Two processes, in any direction."""
    robot: str | None = None
    """Sender or receiver."""
    kind: tuple[str, ...] = ()
    fate: tuple[str, ...] = ()
    steps: tuple[int, int] | None = None
    """The first and the last switching step."""
    from_s: float | None = None
    to_s: float | None = None

    def of(self, messages: Iterable[Message], lines: Iterable[Line]) -> list[Message]:
        """The chosen ones, of a run with these entries."""
        planned = _planned(lines) if self.steps is not None else []
        return [each for each in messages if self._takes(each) and self._in_steps(each.t_s, planned)]

    def _takes(self, message: Message) -> bool:
        ends = {message.sender, message.receiver}
        return (
            (self.link is None or ends == set(self.link))
            and (self.robot is None or self.robot in ends)
            and (not self.kind or message.kind in self.kind)
            and (not self.fate or message.fate in self.fate)
            and (self.from_s is None or message.t_s >= self.from_s)
            and (self.to_s is None or message.t_s <= self.to_s)
        )

    def _in_steps(self, t_s: float, planned: Sequence[tuple[float, int]]) -> bool:
        """A step lasts until the next is planned."""
        if self.steps is None:
            return True
        place = bisect_right(planned, t_s, key=lambda each: each[0])
        return place > 0 and self.steps[0] <= planned[place - 1][1] <= self.steps[1]


def _planned(lines: Iterable[Line]) -> list[tuple[float, int]]:
    """When each switching step was planned."""
    return sorted(
        (entry.t_s, entry.record.step)
        for _, entry in lines
        if isinstance(entry.record, StepPlanned) and not entry.record.joins
    )
