"""The events that the world's core processes."""

from msgspec import Struct

from protocol.exit_codes import ExitCode
from protocol.fence import Change
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import Entry
from protocol.wire.messages import Drive


class OrderHeard(Struct, frozen=True, gc=False):
    """A robot's newest drive order has arrived."""

    robot: int
    drive: Drive


class FencePut(Struct, frozen=True, gc=False):
    """A robot asks for a change of the fence; robot 0 is the operator."""

    robot: int
    change: Change


class ScanAsked(Struct, frozen=True, gc=False):
    """A robot queries a scan."""

    robot: int
    revolutions: int


class EntryWritten(Struct, frozen=True, gc=False):
    """The recorder has written an entry of the world or of a robot."""

    source: str
    entry: Entry


class EntryRead(Struct, frozen=True, gc=False):
    """An entry was read from the timeline: each once, in the order of the lines."""

    source: str
    entry: Entry


class MessageDropped(Struct, frozen=True, gc=False):
    """An arriving message broke the protocol."""

    key: str
    reason: str


class StopAsked(Struct, frozen=True, gc=False):
    """The launcher asks the run to end; with this exit code, unless the run has failed before."""

    exit_code: ExitCode


Event = (
    OrderHeard
    | FencePut
    | ScanAsked
    | TokenCame
    | TokenWent
    | EntryWritten
    | EntryRead
    | MessageDropped
    | StopAsked
)
