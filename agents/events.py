"""What may happen to a robot."""

from dataclasses import dataclass

from protocol.messages import AheadState, Announcement, BehindState, Odometry, Scan


@dataclass(frozen=True, slots=True)
class OdometryHeard:
    """The body tells where it is, and what time it is."""

    odometry: Odometry


@dataclass(frozen=True, slots=True)
class ScanHeard:
    """A scan that was asked for."""

    scan: Scan


@dataclass(frozen=True, slots=True)
class MusterHeard:
    """Another robot says something to all."""

    robot: int
    muster: Announcement


@dataclass(frozen=True, slots=True)
class LinkHeard:
    """A robot tells its link state, with the number that it gave the message."""

    robot: int
    number: int
    state: AheadState | BehindState


@dataclass(frozen=True, slots=True)
class TokenCame:
    """A process shows that it lives; robot 0 is the world."""

    robot: int
    incarnation: str


@dataclass(frozen=True, slots=True)
class TokenWent:
    """A process shows that no longer: it has died, is frozen, or cut off; or this robot is."""

    robot: int
    incarnation: str


Event = OdometryHeard | ScanHeard | MusterHeard | LinkHeard | TokenCame | TokenWent
