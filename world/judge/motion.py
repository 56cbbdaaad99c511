"""How bodies move, from their sampled poses: S3, and the parts of F1 and F3 that motion shows.

Rule 1 (S3): a body moves only with an accepted order, straight from the place of acceptance towards the
        target, and no faster than its limit.
Rule 2 (F1): a body moves only while its newest accepted order bears the fence in force. So when the fence
        changes it stands until it has accepted an order under the new one.
Rule 3 (F3): while a fence names one robot, only that robot moves; under ALL, only members of the strand move;
        otherwise nobody moves.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import FenceChanged, OrderAccepted, PoseSampled, PromiseBroken
from world.judge.evidence import ROUNDING_M, Evidence, Taken, apart_m
from world.judge.fences import ROUNDING_S


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """The allowed deviation of a body from its line."""

    mu0_m: float
    heading_error_rad: float
    speed_mps_max: float

    def drive_m(self, length_m: float) -> float:
        """The largest drive error over so many metres."""
        return ROUNDING_M + self.heading_error_rad * length_m


@dataclass(frozen=True, slots=True)
class _Drive:
    """A motion between two samples, straight and at constant speed."""

    start_s: float
    end_s: float
    start: PoseSampled
    end: PoseSampled

    @property
    def moved_m(self) -> float:
        return math.hypot(self.end.x_m - self.start.x_m, self.end.y_m - self.start.y_m)


def judge_motion(evidence: Evidence, tolerance: Tolerance) -> Iterator[tuple[float, PromiseBroken]]:
    """Every violation with its time; a motion that stays unlawful in the same way is one violation."""
    for robot, poses in sorted(evidence.poses.items()):
        taken = evidence.orders.get(robot, ())
        taken_s, origins = [each.t_s for each in taken], _origins(taken)
        before: set[str] = set()
        for (start_s, start), (end_s, end) in pairwise(poses):
            drive = _Drive(start_s, end_s, start, end)
            if drive.moved_m <= ROUNDING_M:
                continue
            in_hand = bisect_right(taken_s, start_s + ROUNDING_S) - 1
            order = taken[in_hand].order if in_hand >= 0 else None
            found = [
                *_off_course(drive, order, origins[in_hand] if in_hand >= 0 else None, tolerance),
                *_out_of_turn(evidence, drive, order),
            ]
            yield from ((end_s, breach) for breach in found if breach.invariant not in before)
            before = {breach.invariant for breach in found}


def _off_course(
    drive: _Drive, order: OrderAccepted | None, origin: Point | None, tolerance: Tolerance
) -> Iterator[PromiseBroken]:
    """Rule 1."""
    robot, moved_m = drive.start.robot, drive.moved_m
    if order is None or origin is None or order.target is None:
        yield breach_of("S3", robot, moved_m, 0.0, "moved with no order in hand")
        return
    beside_m = max(_beside_m(origin, order.target, place) for place in (drive.start, drive.end))
    allowed_m = tolerance.drive_m(apart_m(origin, order.target))
    reach_m = tolerance.speed_mps_max * (drive.end_s - drive.start_s) + ROUNDING_M
    if beside_m > allowed_m:
        yield breach_of("S3", robot, beside_m, allowed_m, "moved off the line to its target")
    elif moved_m > reach_m:
        yield breach_of("S3", robot, moved_m, reach_m, "moved faster than it can")


def _out_of_turn(evidence: Evidence, drive: _Drive, order: OrderAccepted | None) -> Iterator[PromiseBroken]:
    """Rules 2 and 3: at most one violation of each."""
    robot, moved_m = drive.start.robot, drive.moved_m
    in_force = [evidence.fences[index] for index in evidence.fences.during(drive.start_s, drive.end_s)]
    if order is not None and order.target is not None:
        other = (each for each in in_force if (each.epoch, each.turn) != (order.epoch, order.turn))
        if (fence := next(other, None)) is not None:
            bears, now = (f"turn {each.turn} of epoch {each.epoch}" for each in (order, fence))
            why = f"moved by an order of {bears} in {now}"
            yield breach_of("F1", robot, moved_m, 0.0, why)
    if (fence := next((each for each in in_force if not _may_move(evidence, each, robot)), None)) is not None:
        why = f"moved in turn {fence.turn} of epoch {fence.epoch}, in which {_told(fence)} may move"
        yield breach_of("F3", robot, moved_m, 0.0, why)


def _may_move(evidence: Evidence, fence: FenceChanged, robot: int) -> bool:
    """Rule 3; F4 asks for the formation, so where it is not known every robot counts as a member."""
    if fence.may is May.ALL:
        formed = evidence.formed.get(fence.epoch)
        return formed is None or robot in formed.ranks
    return fence.may is May.ONE and fence.named == robot


def _told(fence: FenceChanged) -> str:
    match fence.may:
        case May.ALL:
            return "only members of the strand"
        case May.ONE:
            return f"only robot {fence.named}"
        case May.NOBODY | May.STOPPED:
            return "nobody"


def _origins(taken: Sequence[Taken]) -> list[Point]:
    """Where the body began each drive; successive orders to one target under one fence are one drive."""
    origins: list[Point] = []
    for index, each in enumerate(taken):
        order, before = each.order, taken[index - 1]
        same = index > 0 and (before.order.target, before.fence) == (order.target, each.fence)
        origins.append(origins[-1] if same else Point(x_m=order.x_m, y_m=order.y_m))
    return origins


def breach_of(
    invariant: str, robot: int, measured_m: float, required_m: float, why: str, *, other: int | None = None
) -> PromiseBroken:
    """A violation with a length."""
    return PromiseBroken(
        invariant=invariant,
        robot=robot,
        other=other,
        measured_m=measured_m,
        required_m=required_m,
        why=why,
    )


def _beside_m(start: Point, end: Point, place: PoseSampled) -> float:
    """The distance of a place from the segment between two points."""
    east_m, north_m = end.x_m - start.x_m, end.y_m - start.y_m
    square = east_m * east_m + north_m * north_m
    along = (place.x_m - start.x_m) * east_m + (place.y_m - start.y_m) * north_m
    share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(place.x_m - start.x_m - share * east_m, place.y_m - start.y_m - share * north_m)
