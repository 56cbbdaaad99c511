"""N unicycle bodies: they execute drive orders, tick by tick.

Rule 1: within one tick a body turns on the spot, drives straight, or stands. So the motion of a tick is a
        segment, and its angle or length is exact.
Rule 2: a body drives at the ordered speed, v_min < v < v_max, equation (1). Only the last tick of a drive is
        shorter.
Rule 3: an order is accepted once, by its number; older or equal numbers change nothing.
Rule 4: a body drives its course straight to the end and stands. With drive error the course misses the target
        by at most `heading_error_rad` times the length; the order is finished nevertheless.
Rule 5: an order is valid for `deadman_s` after its basis, however late it arrived; then the body stands. It
        continues when its robot confirms the order by a newer basis with the same number.
Rule 6: an order with a time limit is driven until then, and longer if a later limit arrives.
Rule 7 (F1): an order to drive is accepted, confirmed or resumed only if it bears exactly the fence, and the
        fence names its robot (`protocol.fence`). An order to stand bears none and is always obeyed.
        When the fence changes, every body stands and has no order in hand.
Rule 8: a tick in which every body continues as in the tick before has the same result whether it is computed
        in full (`tick`) or only added (`coast`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from protocol.arrays import Flags, Floats
from protocol.errors import MessageRefusedError
from protocol.fence import Bearing, Fence, May, obeys
from protocol.frames import Point, Pose, wrap
from protocol.mission import DEADMAN_S
from protocol.wire.messages import Drive
from world.scenario.sections import DriveSection

ROUNDING_M = 1e-9  # error of positions: a robot sent straight on must not stop because of it
TICKS_MAX = 1e9  # more ticks than a run has
LANDING_TICKS = 2  # margin before a body reaches its end: more than rounding errors of the remaining way
ROUNDING_S = 1e-9  # error of sums over ticks


@dataclass(frozen=True, slots=True)
class Moves:
    """The motion of all bodies in one tick; bodies are given by index."""

    starts_m: Floats
    """(N, 2) [world frame]; between start and end each body moved straight at constant speed."""
    ends_m: Floats
    veered: Flags
    """The bodies that move differently than in the tick before."""
    finished: Sequence[int]
    stopped: Sequence[int]
    """The bodies that the dead-man stop has stopped on their way."""


class Bodies:
    """The poses of all bodies, and their present orders."""

    def __init__(
        self, starts: Sequence[Pose], limits: DriveSection, errors: Sequence[np.random.Generator]
    ) -> None:
        count = len(starts)
        self._place_m: Floats = np.array([(pose.x_m, pose.y_m) for pose in starts]).reshape(count, 2)
        self._place_is_due = False  # computed on demand
        self.heading_rad: Floats = np.array([pose.heading_rad for pose in starts])
        self.orders: list[Drive | None] = [None] * count
        """The order that each body has in hand, or the last one that it has finished under the fence."""
        self.finished_number = [0] * count
        self.ordered = [0] * count
        """The number of the newest order that each body has accepted."""
        self._limits = limits
        self._errors = errors  # one random stream per body: the order of arrival must not matter
        self._under_way: Flags = np.zeros(count, dtype=bool)
        self._held: Flags = np.zeros(count, dtype=bool)
        self._basis_s: Floats = np.zeros(count)
        self._until_s: Floats = np.full(count, math.inf)
        self._course_rad = self.heading_rad.copy()
        self._origin_m = self.place_m.copy()
        self._landing_m = self.place_m.copy()
        self._length_m, self._driven_m, self._speed_mps = np.zeros(count), np.zeros(count), np.zeros(count)
        self._run = np.zeros(count, dtype=np.int64)
        self._last_run = self._run.copy()
        self._last_step_m = np.zeros(count)
        self._none: Flags = np.zeros(count, dtype=bool)
        self._at_rest = True
        """Whether no body drove in the last tick."""
        self._same_ticks = 0
        """How many more ticks are certain to be like the last one."""
        self._same_until_s = -math.inf
        self._turning: list[int] = []  # the bodies that turn in such a tick

    @property
    def place_m(self) -> Floats:
        """(N, 2) [world frame]; a returned array never changes."""
        if self._place_is_due:
            self._place_is_due = False
            self._place_m = np.where((self._last_step_m > 0.0)[:, None], self._on_way_m(), self._place_m)
        return self._place_m

    @property
    def moving(self) -> Flags:
        """The bodies that turn or drive."""
        return self._under_way & ~self._held

    def is_moving(self, body: int) -> bool:
        """Whether a body turns or drives."""
        return bool(self._under_way[body] and not self._held[body])

    def pose(self, body: int) -> Pose:
        """The pose of a body [world frame]."""
        x_m, y_m = self.place_m[body].tolist()
        return Pose(x_m=x_m, y_m=y_m, heading_rad=float(self.heading_rad[body]))

    @property
    def courses_m(self) -> Floats:
        """(N, 4) [world frame]: from x, y to x, y, the straight course of each body."""
        return np.hstack((self._origin_m, self._landing_m))

    def straight_ticks(self, steps_m: Floats) -> int:
        """For how many more ticks like the last one no body reaches its end, by the present orders.

        Args:
            steps_m: distance that each body drove in the last tick (N,).
        """
        driving = steps_m > 0.0
        left_m = (self._length_m - self._driven_m)[driving]
        return int((left_m / steps_m[driving]).min(initial=TICKS_MAX))

    def basis_s(self, body: int) -> float:
        """When the body's robot was last known to be awake: the basis of its newest order."""
        return float(self._basis_s[body])

    def resume(self, body: int, pose: Pose, *, ordered: int, finished: int, now_s: float) -> None:
        """Stand at this pose without an order in hand."""
        self._place_m[body], self.heading_rad[body] = (pose.x_m, pose.y_m), pose.heading_rad
        self.ordered[body], self.finished_number[body] = ordered, finished
        self._basis_s[body] = now_s

    def stand(self) -> None:
        """Stop all bodies and drop their orders: the fence changes, or the run is over."""
        self._under_way[:] = False
        self.orders = [None] * len(self.orders)
        self._same_ticks = 0

    def hear(self, body: int, drive: Drive, fence: Fence, *, now_s: float) -> bool:
        """Process an order under this fence; returns whether it is new.

        Raises:
            MessageRefusedError: the order is void, or the drive cannot execute it.
        """
        last = self.orders[body]
        if not now_s - DEADMAN_S - ROUNDING_S <= drive.basis_s <= now_s + ROUNDING_S:
            raise MessageRefusedError(
                f"order {drive.number} is void: its basis is {now_s - drive.basis_s:.3f} s old"
            )
        if drive.number < self.ordered[body] or drive.basis_s < self._basis_s[body]:
            return False
        is_same = drive.number == self.ordered[body]
        confirms = is_same and last is not None and last.target is not None
        if (drive.target is not None or confirms) and not obeys(fence, body + 1, drive.bearing):
            raise MessageRefusedError(
                f"order {drive.number} is void: it bears {_told(drive.bearing)}, and the fence is "
                f"{_told(fence)}, where {_who(fence)} may move"
            )
        low_mps, high_mps = self._limits.speed_mps_min, self._limits.speed_mps_max
        if drive.target is not None and not low_mps < drive.speed_mps < high_mps:
            raise MessageRefusedError(
                f"order {drive.number}: speed must be in ({low_mps}, {high_mps}) m/s, got {drive.speed_mps}"
            )
        until_s = math.inf if drive.until_s is None else drive.until_s
        if not is_same or self._held[body] or until_s < self._until_s[body]:
            self._same_ticks = 0
        self._basis_s[body], self._until_s[body] = drive.basis_s, until_s
        self._held[body] = False
        if is_same:
            return False
        self.orders[body], self.ordered[body] = drive, drive.number
        self._begin(body, drive, last)
        return True

    def _begin(self, body: int, drive: Drive, last: Drive | None) -> None:
        if drive.target is None:
            self._under_way[body] = False
            self.finished_number[body] = drive.number  # an order to stand is finished at once
            return
        self._speed_mps[body] = drive.speed_mps
        if not (self._under_way[body] and last is not None and last.target == drive.target):
            self._lay_course(body, drive.target)

    def _lay_course(self, body: int, target: Point) -> None:
        x_m, y_m = self.place_m[body].tolist()
        length_m = math.hypot(target.x_m - x_m, target.y_m - y_m)
        bearing_rad = math.atan2(target.y_m - y_m, target.x_m - x_m)
        error_rad = self._limits.heading_error_rad
        heading_rad = float(self.heading_rad[body])
        miss_rad = abs(wrap(bearing_rad - heading_rad))
        aims = miss_rad < math.pi / 2 and length_m * (miss_rad - error_rad) <= ROUNDING_M
        if length_m <= ROUNDING_M or aims:
            course_rad = heading_rad
        else:
            course_rad = wrap(bearing_rad + float(self._errors[body].uniform(-error_rad, error_rad)))
        self._under_way[body] = True
        self._course_rad[body] = course_rad
        self._origin_m[body] = (x_m, y_m)
        self._landing_m[body] = (target.x_m, target.y_m)
        if error_rad > 0.0 and length_m > ROUNDING_M:
            self._landing_m[body] = (
                x_m + length_m * math.cos(course_rad),
                y_m + length_m * math.sin(course_rad),
            )
        self._length_m[body], self._driven_m[body] = length_m, 0.0
        self._run[body] += 1

    def tick(self, *, now_s: float, tick_s: float) -> Moves:
        """Move all bodies for one tick from `now_s` on."""
        if self._at_rest and not self._under_way.any():
            self._same_ticks, self._same_until_s, self._turning = int(TICKS_MAX), math.inf, []
            return Moves(self.place_m, self.place_m, self._none, (), ())
        silent = ~self._held & (now_s - self._basis_s > DEADMAN_S + ROUNDING_S)
        stopped = np.flatnonzero(silent & self._under_way)
        self._held |= silent
        moving = self.moving & (now_s + tick_s <= self._until_s + ROUNDING_S)
        turning = moving & (self._course_rad != self.heading_rad)
        if turning.any():
            self._turn(turning, self._limits.turn_rate_radps * tick_s)
        moves = self._drive(moving & ~turning, tick_s, stopped.tolist())
        self._look_ahead(now_s + tick_s, tick_s)
        return moves

    def _look_ahead(self, now_s: float, tick_s: float) -> None:
        """Rule 8: find how long all bodies continue as in the tick that ends now."""
        alive = self.moving
        moving = alive & (now_s + tick_s <= self._until_s)
        turning = moving & (self._course_rad != self.heading_rad)
        driving = moving & ~turning
        if (driving != (self._last_step_m > 0.0)).any() or (moving != alive).any():
            self._same_ticks = 0
            return
        self._turning = np.flatnonzero(turning).tolist()
        self._same_ticks = self.straight_ticks(self._last_step_m) - LANDING_TICKS
        until_s = np.minimum(self._basis_s + DEADMAN_S, self._until_s - tick_s)[alive]
        self._same_until_s = float(until_s.min(initial=math.inf))

    def coast(self, *, now_s: float, tick_s: float) -> bool:
        """Rule 8: repeat the last tick from `now_s` on, if that is certainly correct; else do nothing.

        Two of three ticks are such. With five bodies they take 1/20 of the time of `tick`.
        """
        if self._same_ticks <= 0 or now_s > self._same_until_s:
            return False
        if self._turning and not self._turn_on(self._limits.turn_rate_radps * tick_s):
            return False
        self._same_ticks -= 1
        if not self._at_rest:
            self._driven_m = self._driven_m + self._last_step_m
            self._place_is_due = True
        return True

    def _turn_on(self, reach_rad: float) -> bool:
        """`_turn` for few bodies of which none reaches its course; otherwise do nothing."""
        turned_rad: list[float] = []
        for body in self._turning:
            heading_rad = float(self.heading_rad[body])
            off_rad = _wrapped(float(self._course_rad[body]) - heading_rad)
            if abs(off_rad) <= reach_rad:
                return False
            turned_rad.append(_wrapped(heading_rad + min(max(off_rad, -reach_rad), reach_rad)))
        self.heading_rad = self.heading_rad.copy()
        self.heading_rad[self._turning] = turned_rad
        return True

    def _turn(self, turning: Flags, reach_rad: float) -> None:
        off_rad = np.pi - np.mod(np.pi - (self._course_rad - self.heading_rad), 2 * np.pi)
        turned_rad = self.heading_rad + np.clip(off_rad, -reach_rad, reach_rad)
        turned_rad = np.where(
            np.abs(off_rad) <= reach_rad, self._course_rad, np.pi - np.mod(np.pi - turned_rad, 2 * np.pi)
        )
        self.heading_rad = np.where(turning, turned_rad, self.heading_rad)

    def _drive(self, driving: Flags, tick_s: float, stopped: Sequence[int]) -> Moves:
        starts_m = self.place_m
        left_m = self._length_m - self._driven_m
        step_m = np.where(driving, np.minimum(self._speed_mps * tick_s, left_m), 0.0)
        lands = driving & (left_m - step_m <= 1e-12)  # the rest is rounding error
        self._driven_m = self._driven_m + step_m
        on_way_m = self._on_way_m()
        ends_m = np.where(driving[:, None], np.where(lands[:, None], self._landing_m, on_way_m), starts_m)
        veered = (step_m != self._last_step_m) | ((step_m > 0.0) & (self._run != self._last_run))
        self._last_step_m, self._last_run = step_m, self._run.copy()
        self._at_rest = not step_m.any()
        self._place_m = ends_m
        self._under_way &= ~lands
        finished = np.flatnonzero(lands).tolist()
        for body in finished:
            order = self.orders[body]
            assert order is not None, f"body {body} finished without an order"
            self.finished_number[body] = order.number
        return Moves(starts_m, ends_m, veered, finished, stopped)

    def _on_way_m(self) -> Floats:
        """(N, 2): the position of each body on its course; valid only for driving bodies."""
        whole = np.ones_like(self._length_m)
        share = np.divide(self._driven_m, self._length_m, out=whole, where=self._length_m > 0.0)
        on_way_m: Floats = self._origin_m + (self._landing_m - self._origin_m) * share[:, None]
        return on_way_m


def _wrapped(angle_rad: float) -> float:
    """`wrap` with the same last bit as in `_turn`."""
    return math.pi - (math.pi - angle_rad) % (2 * math.pi)


def _told(bearing: Bearing | Fence) -> str:
    return f"epoch {bearing.epoch.number}, turn {bearing.turn}"


def _who(fence: Fence) -> str:
    return f"robot {fence.robot}" if fence.may is May.ONE else str(fence.may)
