"""Which named points of its step a robot is at, so that a fault plan can strike it exactly there. Pure.

Rule 1: it is asked between a core and the shell that obeys it: the core has decided, nothing is done yet.
Rule 2: whoever is struck has recorded the step that it has planned, and does nothing else of what it decided.
"""

import math
from collections.abc import Sequence

from agents.commands import Command, Note, Order, Tell
from agents.events import Event, OdometryHeard, ScanHeard
from protocol.faults.rules import StepPoint
from protocol.timeline import StepPlanned
from protocol.wire.messages import BehindState, Drive, Odometry


class Points:
    """What has to be remembered of one robot's commands to tell the points that it passes."""

    def __init__(self) -> None:
        self._told = (0, 0)
        """The newest epoch that it acknowledged vertices in, and how many."""
        self._drive: Drive | None = None
        self._leg_m = 0.0
        """How long the way was to the target of the newest order, when that was first given."""
        self._odometry: Odometry | None = None
        self._halved = 0
        """The newest order whose way was seen to be half done."""

    def passed(self, event: Event, commands: Sequence[Command]) -> list[StepPoint]:
        """The points that the robot is at, with what it means to do about an event; asked of each event."""
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
        """Whether the body is seen to have half of the way behind it, for the first time of this order."""
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
        """Whether a robot is to be told of more vertices than before."""
        before = self._told
        for command in commands:
            if isinstance(command, Tell) and isinstance(command.state, BehindState):
                self._told = max(self._told, (command.state.epoch, command.state.vertices))
        return self._told > before


def is_plan(command: Command) -> bool:
    """Whether a command records a switching step."""
    return isinstance(command, Note) and isinstance(command.record, StepPlanned)


def _off_m(odometry: Odometry, drive: Drive) -> float:
    """How far the body is from the order's target; 0 where it has none."""
    pose, target = odometry.pose, drive.target
    return 0.0 if target is None else math.hypot(target.x_m - pose.x_m, target.y_m - pose.y_m)
