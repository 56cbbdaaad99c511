"""The robot's drive orders: numbered, and repeated until done; and its progress along the path.

Rule 1: a restarted robot numbers its orders above all that its former life may have given, and stops the body
        first: it does not know those orders, and some may still be in transit.
"""

import math

from msgspec.structs import replace

from protocol.frames import Point
from protocol.wire.messages import Drive, Odometry

LATE_ORDERS = 1000  # more than a robot gives within the longest delay of an order
NUMBERS_PER_S = 10_000  # far more than it gives: so each life's numbers are above the former life's


class Driver:
    """The newest order, and the body's progress along the strand's path."""

    def __init__(self, *, speed_mps: float, watched: bool = False) -> None:
        self._speed_mps = speed_mps
        self._watched = watched  # if so, an order is valid only once it is permitted
        self.progress_m = 0.0
        """Driven arc length of the path; never decreases."""
        self._odometry: Odometry | None = None
        self._sent_to: tuple[Point, float] | None = None
        """The last target along the path; if the body is stopped on the way, it stands before that."""
        self._ordered_s = 0.0
        self._drive = Drive(
            number=0, basis_s=0.0, target=None, speed_mps=speed_mps, epoch=0, step=0, reach_m=0.0
        )

    @property
    def awake(self) -> bool:
        """Whether odometry has arrived."""
        return self._odometry is not None

    @property
    def standing(self) -> bool:
        """Whether the body has completed the newest order."""
        return self._odometry is not None and self._odometry.finished >= self._drive.number

    @property
    def odometry(self) -> Odometry:
        """The newest odometry."""
        assert self._odometry is not None, "nothing is decided before the first odometry"
        return self._odometry

    @property
    def ordered_s(self) -> float:
        """When the newest order was given; since then the body has been on the way to its target."""
        return self._ordered_s

    @property
    def drive(self) -> Drive:
        """The newest order, with the time at which it was last confirmed."""
        return self._drive

    def hear(self, odometry: Odometry) -> None:
        """Adopt the odometry; it also confirms the current order at its time."""
        self._odometry = odometry
        self._drive = replace(self._drive, basis_s=odometry.t_s)
        if self._sent_to is None:
            return
        target, reach_m = self._sent_to
        remaining_m = math.hypot(target.x_m - odometry.pose.x_m, target.y_m - odometry.pose.y_m)
        there = self.standing and self._drive.target is not None
        self.progress_m = max(self.progress_m, reach_m if there else reach_m - remaining_m)

    @property
    def was_sent(self) -> bool:
        """Whether the body was ordered to drive since the strand formed; it may be moving unseen."""
        return self._sent_to is not None

    def start_again(self) -> None:
        """Begin as the successor of a process that has died (rule 1)."""
        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS
        self._drive = replace(self._drive, number=number)
        self._renew(None, reach_m=0.0, epoch=self._drive.epoch, step=0)
        self._sent_to = None

    def to(self, target: Point, *, reach_m: float, epoch: int, step: int = 0) -> None:
        """Drive straight to a point that lies `reach_m` along the path, without a stop if under way."""
        self._sent_to = (target, reach_m)
        self._renew(target, reach_m=reach_m, epoch=epoch, step=step)

    def permit(self, until_s: float) -> None:
        """The current order is valid until then."""
        self._drive = replace(self._drive, until_s=until_s)

    def begin(self, progress_m: float) -> None:
        """Begin on the path of a strand that has just formed; earlier driving was not on it."""
        if self._drive.target is not None:
            self._renew(None, reach_m=progress_m, epoch=self._drive.epoch, step=0)
        self._sent_to = None
        self.progress_m = progress_m

    def stand(self) -> None:
        """Stop the body where it is, if it is driving."""
        if not self.standing and self._drive.target is not None:
            self._renew(None, reach_m=self.progress_m, epoch=self._drive.epoch, step=0)

    def stand_anew(self, *, epoch: int) -> int:
        """Order the body to stand although it stands; returns the order's number.

        Odometry that reports this number was made after this moment, even if odometry is late.
        """
        self._renew(None, reach_m=self.progress_m, epoch=epoch, step=0)
        return self._drive.number

    @property
    def _at_target_s(self) -> float:
        """The earliest time at which the body may be at the current target, where the permission ends."""
        pose, target = self.odometry.pose, self._drive.target
        assert target is not None
        left_m = math.hypot(target.x_m - pose.x_m, target.y_m - pose.y_m)
        return self.odometry.t_s + left_m / self._speed_mps

    def _renew(self, target: Point | None, *, reach_m: float, epoch: int, step: int) -> None:
        until_s = 0.0 if self._watched else None
        if self._watched and not self.standing and self._drive.target is not None and target is not None:
            until_s = min(self._drive.until_s or 0.0, self._at_target_s)
        else:
            self._ordered_s = self.odometry.t_s
        self._drive = Drive(
            number=self._drive.number + 1,
            basis_s=self.odometry.t_s,
            target=target,
            speed_mps=self._speed_mps,
            epoch=epoch,
            step=step,
            reach_m=reach_m,
            until_s=until_s,
        )
