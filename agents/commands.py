"""The commands of a robot's core, which the shell executes."""

from msgspec import Struct

from protocol.timeline import Record
from protocol.wire.messages import AheadState, Announcement, BehindState, Drive


class Announce(Struct, frozen=True):
    """Send a message to all robots."""

    muster: Announcement


class Tell(Struct, frozen=True):
    """Send the link state to one neighbour."""

    robot: int
    state: AheadState | BehindState


class Order(Struct, frozen=True):
    """Send the newest order to the body."""

    drive: Drive


class AskScan(Struct, frozen=True):
    """Ask the body's sensor for a scan."""

    revolutions: int


class Note(Struct, frozen=True):
    """Add an entry to the timeline."""

    record: Record


Command = Announce | Tell | Order | AskScan | Note
