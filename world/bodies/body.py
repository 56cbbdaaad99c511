"""One unicycle body: it executes drive orders, tick by tick.

Rule 1: within one tick a body turns on the spot, drives straight, or stands. So the motion of a tick is a
        segment, and its angle or length is exact.
Rule 2: a body drives at the ordered speed, v_min < v <= speed_mps < v_max, equation (1). Only the last tick
        of a drive is shorter.
Rule 3: an order is accepted once, by its number; older or equal numbers change nothing.
Rule 4: a body drives its course straight to the end and stands. With drive error the course misses the target
        by at most `heading_error_rad` times the length; the order is finished nevertheless.
Rule 5: an order is valid for `deadman_s` after its basis, however late it arrived; then the body stands. It
        continues when its robot confirms the order by a newer basis with the same number.
Rule 6: an order with a time limit is driven until then, and longer if a later limit arrives.
Rule 7 (F1): an order to drive is accepted, confirmed or resumed only if it bears exactly the fence, and the
        fence names its robot (`protocol.fence`). An order to stand bears none and is always obeyed.
        When the fence changes, every body stands and has no order in hand.
"""

import math
from typing import NamedTuple

import numpy as np

from protocol.errors import MessageRefusedError
from protocol.fence import Bearing, Fence, May, obeys
from protocol.frames import Point, Pose, wrap
from protocol.mission import DEADMAN_S
from protocol.wire.messages import Drive
from world.scenario.sections import DriveSection

ROUNDING_M = 1e-9  # error of positions: a robot sent straight on must not stop because of it
LANDED_M = 1e-12  # of a way that is left: rounding error
ROUNDING_S = 1e-9  # error of sums over ticks


class News(NamedTuple):
    """What is new of a body after a tick."""

    veered: bool = False
    """Whether it moves differently than in the tick before."""
    finished: bool = False
    """Whether it has finished its order."""
    stopped: bool = False
    """Whether the dead-man stop has stopped it on its way."""


NOTHING = News()  # as in most ticks


class Body:
    """The pose of one body, and its present order."""

    def __init__(self, robot: int, start: Pose, limits: DriveSection, errors: np.random.Generator) -> None:
        self._robot = robot
        self._limits = limits
        self._errors = errors
        self.x_m, self.y_m = float(start.x_m), float(start.y_m)
        self.heading_rad = float(start.heading_rad)
        self.order: Drive | None = None
        """The order in hand, or the last one that it has finished under the fence."""
        self.finished_number = 0
        self.ordered = 0
        """The number of the newest order that it has accepted."""
        self.basis_s = 0.0
        """When its robot was last known to be awake: the basis of its newest order."""
        self._until_s = math.inf
        self._under_way = self._held = False
        self._course_rad = self.heading_rad
        self._origin_m = self._landing_m = (self.x_m, self.y_m)
        self._length_m = self._driven_m = self._speed_mps = 0.0
        self._run = self._last_run = 0
        """Counts its courses; that of the last tick."""
        self._last_step_m = 0.0

    @property
    def moves(self) -> bool:
        """Whether it turns or drives."""
        return self._under_way and not self._held

    @property
    def is_at_rest(self) -> bool:
        """Whether ticks change nothing until it hears an order."""
        return not self._under_way and self._last_step_m == 0.0

    @property
    def course_m(self) -> tuple[float, float, float, float]:
        """Its straight course, from x, y to x, y [world frame]."""
        return (*self._origin_m, *self._landing_m)

    def resume(self, pose: Pose, *, ordered: int, finished: int, now_s: float) -> None:
        """Stand at this pose without an order in hand."""
        self.x_m, self.y_m, self.heading_rad = pose.x_m, pose.y_m, pose.heading_rad
        self.ordered, self.finished_number, self.basis_s = ordered, finished, now_s

    def stand(self) -> None:
        """Stop, and drop the order: the fence changes, or the run is over."""
        self._under_way = False
        self.order = None

    def hear(self, drive: Drive, fence: Fence, *, now_s: float) -> bool:
        """Process an order under this fence; returns whether it is new.

        Raises:
            MessageRefusedError: the order is void, or the drive cannot execute it.
        """
        last = self.order
        if not now_s - DEADMAN_S - ROUNDING_S <= drive.basis_s <= now_s + ROUNDING_S:
            raise MessageRefusedError(
                f"order {drive.number} is void: its basis is {now_s - drive.basis_s:.3f} s old"
            )
        if drive.number < self.ordered or drive.basis_s < self.basis_s:
            return False
        is_same = drive.number == self.ordered
        confirms = is_same and last is not None and last.target is not None
        if (drive.target is not None or confirms) and not obeys(fence, self._robot, drive.bearing):
            raise MessageRefusedError(
                f"order {drive.number} is void: it bears {_told(drive.bearing)}, and the fence is "
                f"{_told(fence)}, where {_who(fence)} may move"
            )
        low_mps, high_mps = self._limits.speed_mps_min, self._limits.speed_mps
        if drive.target is not None and not low_mps < drive.speed_mps <= high_mps:
            raise MessageRefusedError(
                f"order {drive.number}: speed must be in ({low_mps}, {high_mps}] m/s, got {drive.speed_mps}"
            )
        until_s = math.inf if drive.until_s is None else drive.until_s
        self.basis_s, self._until_s = drive.basis_s, until_s
        self._held = False
        if is_same:
            return False
        self.order, self.ordered = drive, drive.number
        self._begin(drive, last)
        return True

    def _begin(self, drive: Drive, last: Drive | None) -> None:
        if drive.target is None:
            self._under_way = False
            self.finished_number = drive.number  # an order to stand is finished at once
            return
        self._speed_mps = drive.speed_mps
        if not (self._under_way and last is not None and last.target == drive.target):
            self._lay_course(drive.target)

    def _lay_course(self, target: Point) -> None:
        x_m, y_m, heading_rad = self.x_m, self.y_m, self.heading_rad
        length_m = math.hypot(target.x_m - x_m, target.y_m - y_m)
        bearing_rad = math.atan2(target.y_m - y_m, target.x_m - x_m)
        error_rad = self._limits.heading_error_rad
        miss_rad = abs(wrap(bearing_rad - heading_rad))
        aims = miss_rad < math.pi / 2 and length_m * (miss_rad - error_rad) <= ROUNDING_M
        if length_m <= ROUNDING_M or aims:
            course_rad = heading_rad
        else:
            course_rad = wrap(bearing_rad + float(self._errors.uniform(-error_rad, error_rad)))
        self._under_way = True
        self._course_rad = course_rad
        self._origin_m, self._landing_m = (x_m, y_m), (float(target.x_m), float(target.y_m))
        if error_rad > 0.0 and length_m > ROUNDING_M:
            self._landing_m = (
                x_m + length_m * math.cos(course_rad),
                y_m + length_m * math.sin(course_rad),
            )
        self._length_m, self._driven_m = length_m, 0.0
        self._run += 1

    def tick(self, *, now_s: float, tick_s: float) -> News:
        """Move for one tick from `now_s` on."""
        step_m, finished = 0.0, False
        stopped = self.moves and now_s - self.basis_s > DEADMAN_S + ROUNDING_S
        self._held |= stopped
        if self.moves and now_s + tick_s <= self._until_s + ROUNDING_S:
            if self._course_rad != self.heading_rad:
                self._turn(self._limits.turn_rate_radps * tick_s)
            else:
                left_m = self._length_m - self._driven_m
                step_m = min(self._speed_mps * tick_s, left_m)
                finished = self._drive(step_m, left_m)
        veered = step_m != self._last_step_m or (step_m > 0.0 and self._run != self._last_run)
        self._last_step_m, self._last_run = step_m, self._run
        return News(veered, finished, stopped) if veered or finished or stopped else NOTHING

    def _turn(self, reach_rad: float) -> None:
        off_rad = _wrapped(self._course_rad - self.heading_rad)
        if abs(off_rad) <= reach_rad:
            self.heading_rad = self._course_rad
        else:
            self.heading_rad = _wrapped(self.heading_rad + min(max(off_rad, -reach_rad), reach_rad))

    def _drive(self, step_m: float, left_m: float) -> bool:
        """Drive on; returns whether that finishes the order."""
        self._driven_m += step_m
        if left_m - step_m <= LANDED_M:
            assert self.order is not None, f"body {self._robot} finished without an order"
            self.x_m, self.y_m = self._landing_m
            self._under_way = False
            self.finished_number = self.order.number
            return True
        share = self._driven_m / self._length_m
        (from_x, from_y), (to_x, to_y) = self._origin_m, self._landing_m
        self.x_m, self.y_m = from_x + (to_x - from_x) * share, from_y + (to_y - from_y) * share
        return False


def _wrapped(angle_rad: float) -> float:
    """`wrap` by the remainder towards zero, whose last bits stand in recorded timelines."""
    return math.pi - (math.pi - angle_rad) % (2 * math.pi)


def _told(bearing: Bearing | Fence) -> str:
    return f"epoch {bearing.epoch.number}, turn {bearing.turn}"


def _who(fence: Fence) -> str:
    return f"robot {fence.robot}" if fence.may is May.ONE else str(fence.may)
