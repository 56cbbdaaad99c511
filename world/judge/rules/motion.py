"""How bodies move, from their sampled poses: S3, and the parts of F1 and F3 that motion shows.

Rule 1 (S3): a body moves only with an accepted order, straight from the place of acceptance towards the
        target, and no faster than robots drive. So one that has come to the target stands.
Rule 2 (F1): a body moves only while its newest accepted order bears the fence in force. So when the fence
        changes it stands until it has accepted an order under the new one.
Rule 3 (F3): while a fence names one robot, only that robot moves; under ALL, only members of the strand move;
        otherwise nobody moves.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from protocol.fence import NUMBERS, May
from protocol.frames import Point
from protocol.keys import WORLD, robot_name
from protocol.timeline import Entry, FenceChanged, OrderAccepted, PoseSampled, PromiseBroken
from world.judge.rules.claims import ROUNDING_S, Check, Claim, Claims
from world.judge.rules.evidence import ROUNDING_M, Evidence, apart_m
from world.judge.rules.rule import Dated, breach_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """The allowed deviation of a body from its line."""

    mu0_m: float
    heading_error_rad: float
    speed_mps_max: float

    def drive_m(self, length_m: float) -> float:
        """The largest drive error over so many metres."""
        return ROUNDING_M + self.heading_error_rad * length_m


class _Drive(NamedTuple):
    """A motion between two samples, straight and at constant speed."""

    start_s: float
    end_s: float
    start: PoseSampled
    end: PoseSampled
    moved_m: float


@dataclass(frozen=True, slots=True)
class _Taken:
    """An order that a body accepted."""

    t_s: float
    order: OrderAccepted
    fence: int
    """The fence in force then."""
    origin: Point
    """Where the body began the drive; successive orders to one target under one fence are one drive."""


@dataclass(slots=True)
class _Body:
    """What is known of one body."""

    sampled: tuple[float, PoseSampled] | None = None
    """The newest sample."""
    taken: deque[_Taken] = field(default_factory=deque)
    """The order in hand at the newest sample, and those after it."""
    broken: set[str] = field(default_factory=set)
    """The invariants that its newest motion broke."""

    def take(self, t_s: float, order: OrderAccepted, fence: int) -> None:
        """The body has accepted an order."""
        last = self.taken[-1] if self.taken else None
        same = last is not None and (last.order.target, last.fence) == (order.target, fence)
        origin = last.origin if last is not None and same else Point(x_m=order.x_m, y_m=order.y_m)
        self.taken.append(_Taken(t_s, order, fence, origin))

    def sample(self, t_s: float, pose: PoseSampled) -> tuple[float, PoseSampled] | None:
        """The body has been sampled; returns the sample before."""
        before, self.sampled = self.sampled, (t_s, pose)
        return before

    def breaks(self, invariants: set[str]) -> set[str]:
        """Its newest motion breaks these invariants; returns those that the one before did not break."""
        before, self.broken = self.broken, invariants
        return invariants - before

    def in_hand(self, t_s: float) -> _Taken | None:
        """The order that it had in hand at this time; those before are forgotten."""
        while len(self.taken) > 1 and self.taken[1].t_s <= t_s + ROUNDING_S:
            self.taken.popleft()
        first = self.taken[0] if self.taken else None
        return first if first is not None and first.t_s <= t_s + ROUNDING_S else None


class Motion:
    """Judges the motion of all bodies; a motion that stays unlawful in the same way is one violation."""

    kinds = frozenset[type]({OrderAccepted, PoseSampled})

    def __init__(self, evidence: Evidence, claims: Claims, tolerance: Tolerance) -> None:
        self._evidence = evidence
        self._claims = claims
        self._tolerance = tolerance
        self._bodies: dict[int, _Body] = {}
        self._unknown: dict[int, int] = {}
        """By robot: the newest epoch in which it moved before the formation was recorded."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an order or a sample."""
        record = entry.record
        if source != WORLD or not isinstance(record, OrderAccepted | PoseSampled):
            return
        body = self._bodies.setdefault(record.robot, _Body())
        if isinstance(record, OrderAccepted):
            body.take(entry.t_s, record, self._evidence.fences.newest)
            return
        before = body.sample(entry.t_s, record)
        if before is not None:
            (start_s, start), moved_m = before, apart_m(before[1], record)
            yield from self._judge(body, _Drive(start_s, entry.t_s, start, record, moved_m))

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    def _judge(self, body: _Body, drive: _Drive) -> Iterator[Dated]:
        taken = body.in_hand(drive.start_s)
        if drive.moved_m <= ROUNDING_M:
            return
        found = [
            *_off_course(drive, taken, self._tolerance),
            *_out_of_turn(self._evidence, drive, None if taken is None else taken.order),
        ]
        new = body.breaks({breach.invariant for breach in found})
        yield from ((drive.end_s, breach) for breach in found if breach.invariant in new)
        yield from self._unformed(drive)

    def _unformed(self, drive: _Drive) -> Iterator[Dated]:
        """Rule 3 for a robot's first motion in an epoch whose formation has not been recorded yet."""
        fences, robot = self._evidence.fences, drive.start.robot
        fence = fences[fences.during(drive.start_s, drive.end_s)[-1]]
        known = fence.epoch in self._evidence.formed or self._unknown.get(robot) == fence.epoch
        if fence.may is May.ALL and not known:
            self._unknown[robot] = fence.epoch
            yield from self._claims.judge(drive.end_s, fence.epoch, self._as_member(drive, fence))

    def _as_member(self, drive: _Drive, fence: FenceChanged) -> Check:
        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            if fence.epoch not in self._evidence.formed:  # F4 asks for it
                return claim.awaiting(robot_name(fence.epoch % NUMBERS))
            robot = drive.start.robot
            return [] if _may_move(self._evidence, fence, robot) else [_moved_in(fence, drive)]

        return check


def _off_course(drive: _Drive, taken: _Taken | None, tolerance: Tolerance) -> Iterator[PromiseBroken]:
    """Rule 1."""
    robot, moved_m = drive.start.robot, drive.moved_m
    target = None if taken is None else taken.order.target
    if taken is None or target is None:
        yield breach_of("S3", robot, moved_m, 0.0, "moved with no order in hand")
        return
    beside_m = max(_beside_m(taken.origin, target, place) for place in (drive.start, drive.end))
    allowed_m = tolerance.drive_m(apart_m(taken.origin, target))
    reach_m = tolerance.speed_mps_max * (drive.end_s - drive.start_s) + ROUNDING_M
    back_m = apart_m(drive.end, target) - apart_m(drive.start, target)
    past_m = tolerance.drive_m(allowed_m)  # beside its target a body passes the place nearest to it
    if beside_m > allowed_m:
        yield breach_of("S3", robot, beside_m, allowed_m, "moved off the line to its target")
    elif back_m > past_m:
        yield breach_of("S3", robot, back_m, past_m, "moved away from its target")
    elif moved_m > reach_m:
        yield breach_of("S3", robot, moved_m, reach_m, "moved faster than robots drive")


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
        yield _moved_in(fence, drive)


def _moved_in(fence: FenceChanged, drive: _Drive) -> PromiseBroken:
    why = f"moved in turn {fence.turn} of epoch {fence.epoch}, in which {_told(fence)} may move"
    return breach_of("F3", drive.start.robot, drive.moved_m, 0.0, why)


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


def _beside_m(start: Point, end: Point, place: PoseSampled) -> float:
    """The distance of a place from the segment between two points."""
    east_m, north_m = end.x_m - start.x_m, end.y_m - start.y_m
    square = east_m * east_m + north_m * north_m
    along = (place.x_m - start.x_m) * east_m + (place.y_m - start.y_m) * north_m
    share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(place.x_m - start.x_m - share * east_m, place.y_m - start.y_m - share * north_m)
