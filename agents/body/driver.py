"""The robot's drive orders: numbered, repeated until done, and what they say of its progress.

Rule 1: a robot that is started again goes on behind all orders that its forerunner may have given, and first
        has the body stand: it knows nothing of them, and some may still be on their way.
"""

import math

from msgspec.structs import replace

from protocol.frames import Point
from protocol.wire.messages import Drive, Odometry

LATE_ORDERS = 1000  # more than a robot gives in what an order may be late by
NUMBERS_PER_S = 10_000  # far more than it gives at all: so those of each life are beyond the one's before


class Driver:
    """The newest order, and how far along the strand's path the body is."""

    def __init__(self, *, speed_mps: float, watched: bool = False) -> None:
        self._speed_mps = speed_mps
        self._watched = watched  # then no order is good before it is permitted
        self.progress_m = 0.0
        """Arc length of the path that has been driven; never shrinks."""
        self._odometry: Odometry | None = None
        self._sent_to: tuple[Point, float] | None = None
        """Where along the path the body was last sent: a stop on the way ends between here and there."""
        self._ordered_s = 0.0
        self._drive = Drive(
            number=0, basis_s=0.0, target=None, speed_mps=speed_mps, epoch=0, step=0, reach_m=0.0
        )

    @property
    def awake(self) -> bool:
        """Whether the body has told where it is."""
        return self._odometry is not None

    @property
    def standing(self) -> bool:
        """Whether the newest order has been driven to its end."""
        return self._odometry is not None and self._odometry.finished >= self._drive.number

    @property
    def odometry(self) -> Odometry:
        """The newest that the body told."""
        assert self._odometry is not None, "nothing is decided before the first odometry"
        return self._odometry

    @property
    def ordered_s(self) -> float:
        """When the newest order was given: since then the body has not been beside the way to its target."""
        return self._ordered_s

    @property
    def drive(self) -> Drive:
        """The newest order, with the time that it was confirmed at."""
        return self._drive

    def hear(self, odometry: Odometry) -> None:
        """Take in where the body is; the order in hand is confirmed as of now."""
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
        """Whether it has been sent anywhere since the strand formed; the body may be on its way, unheard."""
        return self._sent_to is not None

    def start_again(self) -> None:
        """Rule 1: this process takes the place of one that has died."""
        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS
        self._drive = replace(self._drive, number=number)
        self._renew(None, reach_m=0.0, epoch=self._drive.epoch, step=0)
        self._sent_to = None

    def to(self, target: Point, *, reach_m: float, epoch: int, step: int = 0) -> None:
        """Drive straight to a point that lies `reach_m` along the path; straight on, if under way."""
        self._sent_to = (target, reach_m)
        self._renew(target, reach_m=reach_m, epoch=epoch, step=step)

    def permit(self, until_s: float) -> None:
        """The order in hand is good until then."""
        self._drive = replace(self._drive, until_s=until_s)

    def begin(self, progress_m: float) -> None:
        """The strand has formed: what was driven until now was not on its path."""
        if self._drive.target is not None:
            self._renew(None, reach_m=progress_m, epoch=self._drive.epoch, step=0)
        self._sent_to = None
        self.progress_m = progress_m

    def stand(self) -> None:
        """Stop where the body is, if it is driving."""
        if not self.standing and self._drive.target is not None:
            self._renew(None, reach_m=self.progress_m, epoch=self._drive.epoch, step=0)

    def stand_anew(self, *, epoch: int) -> int:
        """Order the body to stand, though it does; returns the order's number.

        An odometry that knows of it was made after this moment, however late odometry may be.
        """
        self._renew(None, reach_m=self.progress_m, epoch=epoch, step=0)
        return self._drive.number

    @property
    def _at_target_s(self) -> float:
        """When the body may be at the target in hand: what was permitted covers no more."""
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
