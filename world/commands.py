"""The commands of the world's core; the shell executes them."""

from msgspec import Struct

from protocol.timeline import Record
from protocol.wire.messages import Odometry, Scan


class TellOdometry(Struct, frozen=True, gc=False):
    """Send odometry to a robot."""

    robot: int
    odometry: Odometry


class ServeScan(Struct, frozen=True, gc=False):
    """Reply to a robot's scan query."""

    robot: int
    scan: Scan


class Note(Struct, frozen=True, gc=False):
    """Record an entry in the timeline."""

    t_s: float
    record: Record


Command = TellOdometry | ServeScan | Note
