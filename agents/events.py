"""What may happen to a robot."""

from msgspec import Struct

from protocol.wire.messages import AheadState, Announcement, BehindState, Odometry, Scan


class OdometryHeard(Struct, frozen=True):
    """The body tells where it is, and what time it is."""

    odometry: Odometry


class ScanHeard(Struct, frozen=True):
    """A scan that was asked for."""

    scan: Scan


class MusterHeard(Struct, frozen=True):
    """Another robot says something to all."""

    robot: int
    muster: Announcement


class LinkHeard(Struct, frozen=True):
    """A robot tells its link state, with the number that it gave the message."""

    robot: int
    number: int
    state: AheadState | BehindState


class TokenCame(Struct, frozen=True):
    """A process shows that it lives; robot 0 is the world."""

    robot: int
    incarnation: str


class TokenWent(Struct, frozen=True):
    """A process shows that no longer: it has died, is frozen, or cut off; or this robot is."""

    robot: int
    incarnation: str


Event = OdometryHeard | ScanHeard | MusterHeard | LinkHeard | TokenCame | TokenWent
