"""What may happen to the world."""

from dataclasses import dataclass

from protocol.exit_codes import ExitCode
from protocol.messages import Drive
from protocol.timeline import Entry


@dataclass(frozen=True, slots=True)
class OrderHeard:
    """A robot's newest drive order."""

    robot: int
    drive: Drive


@dataclass(frozen=True, slots=True)
class ScanAsked:
    """A robot wants its sensor read."""

    robot: int
    revolutions: int


@dataclass(frozen=True, slots=True)
class TokenCame:
    """A robot's process shows that it lives."""

    robot: int
    incarnation: str


@dataclass(frozen=True, slots=True)
class TokenWent:
    """A robot's process shows that no longer."""

    robot: int
    incarnation: str


@dataclass(frozen=True, slots=True)
class EntryWritten:
    """The recorder has written an entry, of the world's own or of a robot's."""

    source: str
    entry: Entry


@dataclass(frozen=True, slots=True)
class MessageDropped:
    """A message broke the protocol on its way in."""

    key: str
    reason: str


@dataclass(frozen=True, slots=True)
class StopAsked:
    """The user wants the run to end; with this exit code, unless the run has failed by then."""

    exit_code: ExitCode


Event = OrderHeard | ScanAsked | TokenCame | TokenWent | EntryWritten | MessageDropped | StopAsked
