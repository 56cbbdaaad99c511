"""The robot's drive orders: numbered, and repeated until done; and its progress along the strand's path.

Rule 1: a restarted robot numbers its orders above all that its former life may have given, and stops the body
        first: it does not know those orders, and some may still be in transit. The body stands only when it
        has finished that order.
Rule 2 (F2 of docs/strand.md): motion is ordered only under the fence that the driver bears, while the newest
        odometry tells that fence, and it is in force.
Rule 3 (F1): an order has ended when it is finished, or when odometry tells another fence than it bears: the
        body has dropped it then, and stands. An order that was dropped is not finished, and nor is one where
        odometry tells a higher number: that is another life's, which has stopped the body on its way.
Rule 4: the newest odometry by its fence, then by its number, is valid; older ones change nothing.
Rule 5 (F6): where obstacles move, an order to drive is kept from the body until a scan under that fence has
        permitted it.
"""

from msgspec.structs import replace

from protocol.fence import Bearing, in_force
from protocol.frames import Point, apart_m
from protocol.wire.messages import Drive, Odometry

LATE_ORDERS = 1000  # more than a robot gives within the longest delay of an order
NOT_PERMITTED_S = 0.0  # where obstacles move: the end of an order's permission before any scan gives it one
NUMBERS_PER_S = 10_000  # far more than it gives: so each life's numbers are above the former life's


class Driver:
    """The newest order, and the body's progress along the strand's path."""

    def __init__(self, *, speed_mps: float, watched: bool = False) -> None:
        self._speed_mps = speed_mps
        self._watched = watched  # if so, an order to drive is given only once a scan permits it
        self.progress_m = 0.0
        """Driven arc length of the path; never decreases."""
        self.standing = False
        """Whether the newest order has ended, so that the body stands (rules 1 and 3)."""
        self._is_finished = False
        """Whether the body has finished this very order: a higher number is of a process that replaces it."""
        self._is_dropped = False
        self._odometry: Odometry | None = None
        self._sent_to: tuple[Point, float] | None = None
        """The last target along the path; if the body is stopped on the way, it stands before that."""
        self.ordered_s = 0.0
        """When the newest order was given; since then the body has been on the way to its target."""
        self.bearing = Bearing()
        """What further orders bear."""
        self._stands_from = 0  # rule 1: the number of the order that has to be finished first
        self.drive = Drive(
            number=0,
            basis_s=0.0,
            target=None,
            speed_mps=speed_mps,
            bearing=self.bearing,
            step=0,
            reach_m=0.0,
        )
        """The newest order, with the time at which it was last confirmed."""

    @property
    def awake(self) -> bool:
        """Whether odometry has arrived."""
        return self._odometry is not None

    @property
    def odometry(self) -> Odometry:
        """The newest odometry."""
        assert self._odometry is not None, "nothing is decided before the first odometry"
        return self._odometry

    @property
    def tells(self) -> bool:
        """Whether the body is told the newest order: where obstacles move, to drive once it is permitted."""
        return self.drive.target is None or self.drive.until_s != NOT_PERMITTED_S

    @property
    def may_drive(self) -> bool:
        """Rule 2."""
        return self._odometry is not None and self._is_told(self.bearing) and in_force(self._odometry.fence)

    def hear(self, odometry: Odometry) -> bool:
        """Take in odometry, which also confirms the current order; returns whether it is new (rule 4)."""
        if self._odometry is not None and _age(odometry) <= _age(self._odometry):
            return False
        self._odometry = odometry
        self.drive = replace(self.drive, basis_s=odometry.t_s)
        self._compare()
        if self._sent_to is not None:
            target, reach_m = self._sent_to
            remaining_m = apart_m(target, odometry.pose)
            there = self._is_finished and self.drive.target is not None
            self.progress_m = max(self.progress_m, reach_m if there else reach_m - remaining_m)
        if self._is_dropped and self.drive.target is not None:
            self._renew(None, reach_m=self.progress_m, step=0)  # a dropped order would be refused
        return True

    @property
    def was_sent(self) -> bool:
        """Whether the body was ordered to drive since the robot began here; it may be moving unseen."""
        return self._sent_to is not None

    def start_again(self) -> None:
        """Begin as the successor of a process that has died (rule 1)."""
        number = max(self.odometry.ordered, int(self.odometry.t_s * NUMBERS_PER_S)) + LATE_ORDERS
        self.drive = replace(self.drive, number=number)
        self._renew(None, reach_m=0.0, step=0)
        self._stands_from = self.drive.number
        self._sent_to = None
        self._compare()

    def begin(self, progress_m: float, bearing: Bearing) -> None:
        """Begin on a path, under a fence; earlier driving was not on it."""
        if self.drive.target is not None:
            self._renew(None, reach_m=progress_m, step=0)
        if self.odometry.ordered > self.drive.number:  # of another process, which orders nothing any more
            self.drive = replace(self.drive, number=self.odometry.ordered + LATE_ORDERS)
            self._compare()
        self._sent_to = None
        self.progress_m = progress_m
        self.bearing = bearing

    def to(self, target: Point, *, reach_m: float, step: int = 0) -> None:
        """Drive straight to a point that lies `reach_m` along the path, without a stop if under way."""
        if self.may_drive:
            self._sent_to = (target, reach_m)
            self._renew(target, reach_m=reach_m, step=step)

    def permit(self, until_s: float) -> None:
        """The current order is valid until then."""
        self.drive = replace(self.drive, until_s=until_s)

    def stand(self) -> None:
        """Stop the body where it is, if it is driving."""
        if not self.standing and self.drive.target is not None:
            self._renew(None, reach_m=self.progress_m, step=0)

    def end_at(self, progress_m: float) -> None:
        """The path ends where the body stands, which is as far as this."""
        self.progress_m = progress_m

    def _is_told(self, bearing: Bearing) -> bool:
        """Whether the newest odometry tells the fence that an order bears."""
        fence = self.odometry.fence
        return fence.turn == bearing.turn and fence.epoch == bearing.epoch

    def _compare(self) -> None:
        """There is new odometry, or another order: both are asked for several times in each event."""
        odometry = self.odometry
        self._is_finished = odometry.finished == self.drive.number
        self._is_dropped = not self._is_told(self.drive.bearing)
        self.standing = odometry.finished >= self._stands_from and (self._is_finished or self._is_dropped)

    @property
    def _at_target_s(self) -> float:
        """The earliest time at which the body may be at the current target, where the permission ends."""
        pose, target = self.odometry.pose, self.drive.target
        assert target is not None
        return self.odometry.t_s + apart_m(target, pose) / self._speed_mps

    def _renew(self, target: Point | None, *, reach_m: float, step: int) -> None:
        until_s = NOT_PERMITTED_S if self._watched else None
        if self._watched and not self.standing and self.drive.target is not None and target is not None:
            until_s = min(self.drive.until_s or NOT_PERMITTED_S, self._at_target_s)
        else:
            self.ordered_s = self.odometry.t_s
        self.drive = Drive(
            number=self.drive.number + 1,
            basis_s=self.odometry.t_s,
            target=target,
            speed_mps=self._speed_mps,
            bearing=self.bearing,
            step=step,
            reach_m=reach_m,
            until_s=until_s,
        )
        self._compare()


def _age(odometry: Odometry) -> tuple[tuple[int, int, int], int]:
    """Rule 4."""
    return odometry.fence.key, odometry.n
