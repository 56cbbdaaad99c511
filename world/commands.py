"""The commands of the world's core; the shell executes them."""

from msgspec import Struct

from protocol.timeline import Record
from protocol.wire.messages import Odometry, Scan


class TellOdometry(Struct, frozen=True):
    """Send odometry to a robot."""

    robot: int
    odometry: Odometry


class ServeScan(Struct, frozen=True):
    """Reply to a robot's scan query."""

    robot: int
    scan: Scan


class Note(Struct, frozen=True):
    """Record an entry in the timeline."""

    t_s: float
    record: Record


Command = TellOdometry | ServeScan | Note
