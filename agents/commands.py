"""The commands of a robot's core, which the shell executes."""

from msgspec import Struct

from protocol.fence import Raise, Turn
from protocol.timeline import Record
from protocol.wire.messages import AheadState, BehindState, Drive
from protocol.wire.view import ViewMessage


class Say(Struct, frozen=True, gc=False):
    """Send a message of a view to one robot."""

    robot: int
    said: ViewMessage


class Put(Struct, frozen=True, gc=False):
    """Ask the register to change the fence."""

    change: Raise | Turn


class Tell(Struct, frozen=True, gc=False):
    """Send the link state to one neighbour."""

    robot: int
    state: AheadState | BehindState


class Order(Struct, frozen=True, gc=False):
    """Send the newest order to the body."""

    drive: Drive


class AskScan(Struct, frozen=True, gc=False):
    """Ask the body's sensor for a scan."""

    revolutions: int


class Note(Struct, frozen=True, gc=False):
    """Add an entry to the timeline."""

    record: Record


Command = Say | Put | Tell | Order | AskScan | Note
