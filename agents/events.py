"""The events for a robot's core."""

from msgspec import Struct

from protocol.process.tokens import TokenCame, TokenWent
from protocol.wire.messages import AheadState, BehindState, Odometry, Scan
from protocol.wire.view import ViewMessage


class OdometryHeard(Struct, frozen=True, gc=False):
    """Odometry: the body's pose and the time."""

    odometry: Odometry


class ScanHeard(Struct, frozen=True, gc=False):
    """An answer to a scan query."""

    scan: Scan


class ViewHeard(Struct, frozen=True, gc=False):
    """A message of a view from another robot, with the number of the message."""

    robot: int
    number: int
    said: ViewMessage


class LinkHeard(Struct, frozen=True, gc=False):
    """A neighbour's link state, with the number of the message."""

    robot: int
    number: int
    state: AheadState | BehindState


class TokensSeen(Struct, frozen=True, gc=False):
    """Tokens that came one after the other, as when a process connects: one event, since a fleet has many."""

    shown: tuple[tuple[int, str], ...]
    """Pairs of robot and incarnation; a journal takes no numbers as keys."""


class TokensWatched(Struct, frozen=True, gc=False):
    """From now on, these robots' tokens are watched and no others; those that are shown have come."""

    robots: tuple[int, ...] | None
    """None: all robots'."""


Event = OdometryHeard | ScanHeard | ViewHeard | LinkHeard | TokenCame | TokenWent | TokensSeen | TokensWatched
