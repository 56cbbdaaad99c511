"""What may happen to a robot."""

from dataclasses import dataclass

from protocol.messages import AheadState, BehindState, Muster, Odometry, Scan


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
    """Another robot announces itself."""

    robot: int
    muster: Muster


@dataclass(frozen=True, slots=True)
class LinkHeard:
    """A robot tells its link state, with the number that it gave the message."""

    robot: int
    number: int
    state: AheadState | BehindState


Event = OdometryHeard | ScanHeard | MusterHeard | LinkHeard
