"""A robot's process as its journal tells it, in memory: what it heard, what it decided, what it sent.

Rule 1: a shell numbers the messages of each key from 1, in the order of the core's commands. So the journal
        tells the number of each message that a process sent.
Rule 2: the last decision of a process that was killed may not have been carried out.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

import msgspec

from agents.commands import Command, Order, Put, Say, Tell
from agents.events import Event, LinkHeard, OdometryHeard, ScanHeard, ViewHeard
from agents.process import addresses
from clew.log.journals.recording import Recording, Turn
from clew.log.replay_missing import journals_in, missing, told
from protocol.errors import UsageError
from protocol.faults.message_faults import sender_of
from protocol.keys import robot_name
from protocol.network.session import INPUTS
from protocol.wire.messages import Message

COMMANDS = {kind.__name__: kind for kind in get_args(Command)}
KEYS: MappingProxyType[str, Callable[[int, Any], str]] = MappingProxyType(
    {
        Say.__name__: lambda robot, fields: addresses.view(robot, fields["robot"]),
        Tell.__name__: lambda robot, fields: addresses.link(robot, fields["robot"]),
        Put.__name__: lambda robot, _: addresses.fence(robot),
        Order.__name__: lambda robot, _: addresses.drive(robot),
    }
)
"""The keys of the commands that send a message."""


@dataclass(frozen=True, slots=True)
class Sent:
    """A message that a process sent."""

    turn: int
    """Index of the turn in which it was decided."""
    t_s: float
    kind: str
    """Of its command."""
    fields: Any
    """As in the journal: most are never looked at."""

    @property
    def command(self) -> Say | Tell | Put | Order:
        """The command that sent it."""
        command = command_of(self.kind, self.fields)
        assert isinstance(command, Say | Tell | Put | Order), self.kind
        return command

    @property
    def message(self) -> Message:
        """The message itself."""
        match self.command:
            case Say(said=message) | Tell(state=message) | Put(change=message) | Order(drive=message):
                return message


class Process:
    """One process of a robot."""

    def __init__(self, recording: Recording) -> None:
        """Read its journal."""
        self.path = recording.path
        self.head = recording.head
        self.robot = recording.head.robot
        self.name = robot_name(self.robot)
        self.turns: tuple[Turn, ...] = tuple(recording.turns())
        self.flaw = recording.flaw or recording.unkept
        """What is wrong with the last record that was read, or what was not kept; or None."""

    def commands(self, turn: int, *, only: type[Command] | None = None) -> Iterator[Command]:
        """The recorded commands of a turn, or those of one kind."""
        decision = self.turns[turn].decision
        for kind, fields in () if decision is None else decision.commands:
            if only is None or kind == only.__name__:
                yield command_of(kind, fields)

    @cached_property
    def sent(self) -> dict[tuple[str, int], Sent]:
        """Rule 1: all its messages, by key and number."""
        sent: dict[tuple[str, int], Sent] = {}
        counts: Counter[str] = Counter()
        for index, turn in enumerate(self.turns):
            for kind, fields in () if turn.decision is None else turn.decision.commands:
                if kind in KEYS:
                    key = KEYS[kind](self.robot, fields)
                    counts[key] += 1
                    sent[key, counts[key]] = Sent(index, turn.input.now_s, kind, fields)
        return sent


def processes_of(run: Path) -> list[Process]:
    """All processes with a journal in the folder of a run, by robot and then by time.

    Raises:
        UsageError: a file in the place of a journal is none.
    """
    found = map(Process, journals_in(run, "*"))
    # A process that was started again has heard of tokens at 0 s, before its first odometry.
    return sorted(found, key=lambda each: (each.robot, each.turns[-1].input.now_s if each.turns else 0.0))


def gaps(run: Path, processes: Sequence[Process]) -> Iterator[str]:
    """What of the inputs of a run's robots is missing, in sentences."""
    if not processes:
        yield f"{run / INPUTS} has no journals of robots, so what they heard and decided is unknown"
        return
    for each in missing(run, [process.head for process in processes], None) or ():
        if each.excuse is None:
            yield told(each)
    for process in processes:
        if process.flaw is not None:
            yield f"{process.path.name}: {process.flaw}"


def command_of(kind: str, fields: object) -> Command:
    """A command, from what a journal has of it.

    Raises:
        UsageError: it is none of this version.
    """
    try:
        command: Command = msgspec.convert(fields, COMMANDS[kind])
    except (KeyError, msgspec.ValidationError) as error:
        raise UsageError(f"a journal has a command {kind!r} that this version does not know") from error
    return command


def sender_process(
    processes: Sequence[Process],
    place: tuple[str, int],
    t_s: float,
    *,
    receiver: str,
    message: Message | None = None,
) -> Process | None:
    """The process of a robot that sent a message; None: its journal is missing.

    A robot that was started again counts its messages anew: then the content decides, and the time where that
    is the same or not known.

    Args:
        processes: all of the run.
        place: the message's key, and its number on that key.
        t_s: when it was received or struck, by the receiver's clock.
        receiver: the process that received it.
        message: what it said, if that is known.
    """
    sender = sender_of(place[0], receiver)
    found = [each for each in processes if each.name == sender and place in each.sent]
    same = [each for each in found if message is None or each.sent[place].message == message]
    return min(same or found, key=lambda each: abs(each.sent[place].t_s - t_s), default=None)


def message_in(event: Event) -> Message | None:
    """The message that carried an event; None: it is of liveliness tokens."""
    match event:
        case OdometryHeard(message) | ScanHeard(message):
            return message
        case LinkHeard(state=message) | ViewHeard(said=message):
            return message
        case _:
            return None
