"""The messages of a run: those that robots took in, from their journals, and those that were lost or refused.

Rule 1: a robot's journal has what its core was given, so a copy of a message that it had is not in it.
Rule 2: the world keeps no journal: of orders, puts and queries only those are known that did not arrive.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from agents.events import Event, LinkHeard, OdometryHeard, ScanHeard, ViewHeard
from agents.process.journal import SUFFIX, Recording
from protocol.faults.message_faults import sender_of
from protocol.keys import robot_name
from protocol.network.session import INPUTS
from protocol.timeline import FaultInjected, MessageRefused
from world.judge.books import TAKES_AWAY
from world.record.lines import Line

DELIVERED, REFUSED = "delivered", "refused"


@dataclass(frozen=True, slots=True, order=True)
class Message:
    """A message, at the process that received it or should have."""

    t_s: float
    """The receiver's time when it came, or when a fault took it."""
    sender: str
    receiver: str
    kind: str
    """Its kind as in fault plans, `ahead`; of one that was lost or refused, the family of its key: `link`."""
    key: str
    number: int
    """On that key; 0: it has none, or it was refused."""
    fate: str
    """`delivered`, `refused`, or the fault that took it: `drop`, `partition`, `corrupt`."""
    rule: str = ""
    """The rule that took it."""


def messages_of(folder: Path, lines: Sequence[Line]) -> list[Message]:
    """All messages of a run with this folder and these entries, by time.

    Raises:
        UsageError: a file in the place of a journal is none.
    """
    delivered = (each for path in sorted((folder / INPUTS).glob(f"*{SUFFIX}")) for each in _delivered(path))
    return sorted([*delivered, *_lost(lines)])


def _delivered(journal: Path) -> Iterator[Message]:
    recording = Recording(journal)
    receiver = robot_name(recording.head.robot)
    for turn in recording.turns():
        if (kind := _kind_of(turn.event)) is not None:
            heard = turn.input
            sender = sender_of(heard.key, receiver)
            yield Message(heard.now_s, sender, receiver, kind, heard.key, heard.number, DELIVERED)


def _kind_of(event: Event) -> str | None:
    """The kind of the message that carried an event; None: no message did."""
    match event:
        case OdometryHeard(odometry):
            message: object = odometry
        case ScanHeard(scan):
            message = scan
        case LinkHeard(state=state):
            message = state
        case ViewHeard(said=said):
            message = said
        case _:
            return None  # a liveliness token
    return str(type(message).__struct_config__.tag)  # type: ignore[attr-defined] # all messages are Structs


def _lost(lines: Sequence[Line]) -> Iterator[Message]:
    for source, entry in lines:
        match entry.record:
            case FaultInjected(fault=fault, rule=rule, key=str(key), number=number) if fault in TAKES_AWAY:
                yield _lost_at(source, entry.t_s, key, (number or 0, fault, rule))
            case MessageRefused(key=key):
                yield _lost_at(source, entry.t_s, key, (0, REFUSED, ""))
            case _:
                pass  # no message


def _lost_at(receiver: str, t_s: float, key: str, end: tuple[int, str, str]) -> Message:
    """A message that did not arrive; `end`: its number, its fate, and the rule."""
    return Message(t_s, sender_of(key, receiver), receiver, _family(key), key, *end)


def _family(key: str) -> str:
    """The part of a key that tells its messages: `link`, `view`, or what of a body it is about."""
    parts = key.split("/")
    return parts[-1] if parts[0] == "body" and parts[1:2] != ["fence"] else parts[parts[0] == "body"]
