"""The named points of a step that a robot passes, where a fault plan can inject process faults. Pure.

Rule 1: the shell calls it when the core has decided and nothing has been executed.
Rule 2: a robot that suffers a fault at a point has recorded its planned step, and executes nothing else of
        its decision.
"""

from collections.abc import Sequence

from agents.commands import Command, Note, Order, Tell
from agents.events import Event, OdometryHeard, ScanHeard
from protocol.faults.rules import StepPoint
from protocol.frames import apart_m
from protocol.timeline import StepPlanned
from protocol.wire.messages import BehindState, Drive, Odometry


class Points:
    """The state that is needed to detect the points that one robot passes."""

    def __init__(self) -> None:
        self._told = (0, 0)  # by the epoch's number
        """The newest epoch in which it acknowledged vertices, and how many."""
        self._drive: Drive | None = None
        self._leg_m = 0.0
        """The distance to the target of the newest order when it was first given."""
        self._odometry: Odometry | None = None
        self._halved = 0
        """The newest order that was seen to be half done."""

    def passed(self, event: Event, commands: Sequence[Command]) -> list[StepPoint]:
        """The points that the robot passes with these commands; must be called for each event."""
        points: list[StepPoint] = []
        if isinstance(event, ScanHeard):
            points.append(StepPoint.AFTER_SCAN)
        if any(is_plan(command) for command in commands):
            points.append(StepPoint.AFTER_PLAN)
        if isinstance(event, OdometryHeard) and self._is_halfway(event.odometry):
            points.append(StepPoint.MID_DRIVE)
        if self._acknowledges(commands):
            points.append(StepPoint.BEFORE_ACK)
        for command in commands:
            if isinstance(command, Order):
                self._give(command.drive)
        return points

    def _is_halfway(self, odometry: Odometry) -> bool:
        """Whether the body has driven half of the way, for the first time in this order."""
        self._odometry = odometry
        drive = self._drive
        if drive is None or drive.target is None or not odometry.moving or drive.number <= self._halved:
            return False
        if _off_m(odometry, drive) > self._leg_m / 2.0:
            return False
        self._halved = drive.number
        return True

    def _give(self, drive: Drive) -> None:
        if self._drive is not None and drive.number == self._drive.number:
            return
        self._drive = drive
        self._leg_m = 0.0 if self._odometry is None else _off_m(self._odometry, drive)

    def _acknowledges(self, commands: Sequence[Command]) -> bool:
        """Whether a command acknowledges more vertices than before."""
        before = self._told
        for command in commands:
            if isinstance(command, Tell) and isinstance(command.state, BehindState):
                self._told = max(self._told, (command.state.epoch.number, command.state.vertices))
        return self._told > before


def is_plan(command: Command) -> bool:
    """Whether a command records a switching step."""
    return isinstance(command, Note) and isinstance(command.record, StepPlanned)


def _off_m(odometry: Odometry, drive: Drive) -> float:
    """The distance of the body from the order's target; 0 if there is none."""
    pose, target = odometry.pose, drive.target
    return 0.0 if target is None else apart_m(target, pose)
