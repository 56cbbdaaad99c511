"""What a robot may want done. The shell obeys."""

from dataclasses import dataclass

from protocol.messages import AheadState, Announcement, BehindState, Drive
from protocol.timeline import Record


@dataclass(frozen=True, slots=True)
class Announce:
    """Tell all robots."""

    muster: Announcement


@dataclass(frozen=True, slots=True)
class Tell:
    """Tell one neighbour the state of the link."""

    robot: int
    state: AheadState | BehindState


@dataclass(frozen=True, slots=True)
class Order:
    """Give the body its newest order."""

    drive: Drive


@dataclass(frozen=True, slots=True)
class AskScan:
    """Have the body's sensor read."""

    revolutions: int


@dataclass(frozen=True, slots=True)
class Note:
    """Put an entry into the timeline."""

    record: Record


Command = Announce | Tell | Order | AskScan | Note
