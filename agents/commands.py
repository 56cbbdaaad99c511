"""What a robot may want done. The shell obeys."""

from msgspec import Struct

from protocol.timeline import Record
from protocol.wire.messages import AheadState, Announcement, BehindState, Drive


class Announce(Struct, frozen=True):
    """Tell all robots."""

    muster: Announcement


class Tell(Struct, frozen=True):
    """Tell one neighbour the state of the link."""

    robot: int
    state: AheadState | BehindState


class Order(Struct, frozen=True):
    """Give the body its newest order."""

    drive: Drive


class AskScan(Struct, frozen=True):
    """Have the body's sensor read."""

    revolutions: int


class Note(Struct, frozen=True):
    """Put an entry into the timeline."""

    record: Record


Command = Announce | Tell | Order | AskScan | Note
