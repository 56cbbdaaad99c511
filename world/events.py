"""What may happen to the world."""

from msgspec import Struct

from protocol.exit_codes import ExitCode
from protocol.timeline import Entry
from protocol.wire.messages import Drive


class OrderHeard(Struct, frozen=True):
    """A robot's newest drive order."""

    robot: int
    drive: Drive


class ScanAsked(Struct, frozen=True):
    """A robot wants its sensor read."""

    robot: int
    revolutions: int


class TokenCame(Struct, frozen=True):
    """A robot's process shows that it lives."""

    robot: int
    incarnation: str


class TokenWent(Struct, frozen=True):
    """A robot's process shows that no longer."""

    robot: int
    incarnation: str


class EntryWritten(Struct, frozen=True):
    """The recorder has written an entry, of the world's own or of a robot's."""

    source: str
    entry: Entry


class MessageDropped(Struct, frozen=True):
    """A message broke the protocol on its way in."""

    key: str
    reason: str


class StopAsked(Struct, frozen=True):
    """The user wants the run to end; with this exit code, unless the run has failed by then."""

    exit_code: ExitCode


Event = OrderHeard | ScanAsked | TokenCame | TokenWent | EntryWritten | MessageDropped | StopAsked
