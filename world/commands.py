"""What the world may want done. The shell obeys."""

from dataclasses import dataclass

from protocol.messages import Odometry, Scan
from protocol.timeline import Record


@dataclass(frozen=True, slots=True)
class TellOdometry:
    """Tell a robot of its body."""

    robot: int
    odometry: Odometry


@dataclass(frozen=True, slots=True)
class ServeScan:
    """Answer the robot that asked for a scan."""

    robot: int
    scan: Scan


@dataclass(frozen=True, slots=True)
class Note:
    """Put an entry into the timeline."""

    t_s: float
    record: Record


Command = TellOdometry | ServeScan | Note
