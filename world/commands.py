"""What the world may want done. The shell obeys."""

from msgspec import Struct

from protocol.timeline import Record
from protocol.wire.messages import Odometry, Scan


class TellOdometry(Struct, frozen=True):
    """Tell a robot of its body."""

    robot: int
    odometry: Odometry


class ServeScan(Struct, frozen=True):
    """Answer the robot that asked for a scan."""

    robot: int
    scan: Scan


class Note(Struct, frozen=True):
    """Put an entry into the timeline."""

    t_s: float
    record: Record


Command = TellOdometry | ServeScan | Note
