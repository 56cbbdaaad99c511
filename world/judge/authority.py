"""S3: no body moves without authority. Judged from a run's timeline alone.

Rule 1: a following robot orders its body only to points of the strand's path, and only as far as the robot
        ahead had granted by then in that epoch. A granter's clock is never ahead of the world's, so a grant
        with a later time than the order came too late, whenever it was recorded.
Rule 2: the leader orders its body only to the target of a switching step that it had planned.
Rule 3: a body moves only with an accepted order, straight from the place of acceptance towards the target,
        and no faster than its limit.
Rule 4: if the robot ahead died, its last grants may be unrecorded. So rule 1 excuses an order between that
        robot's last entry and its death.
Rule 5: a robot never reduces a grant within an epoch, since the robot behind may already be there.
Rule 6: while robots line up, a robot orders its body only to the target of a step that it had planned, and
        moves alone (`world.judge.one_at_a_time`). Robots line up in epoch 0, in the epoch after a strand has
        dissolved, and in a called epoch.
"""

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import itemgetter

from protocol.frames import Point
from protocol.timeline import (
    AuthorityGranted,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    StepPlanned,
)
from world.judge.evidence import ROUNDING_M, ROUNDING_S, Evidence, Orders, apart_m
from world.judge.one_at_a_time import judge_one_at_a_time
from world.judge.paths import Paths


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """The allowed deviation of a body from its line."""

    mu0_m: float
    heading_error_rad: float
    speed_mps_max: float

    def drive_m(self, length_m: float) -> float:
        """The largest drive error over so many metres."""
        return ROUNDING_M + self.heading_error_rad * length_m


def judge_authority(evidence: Evidence, tolerance: Tolerance) -> list[tuple[float, PromiseBroken]]:
    """Every violation of S3 with its time; each order and each unlawful motion counts once."""
    paths = Paths(evidence)
    breaches: list[tuple[float, PromiseBroken]] = []
    for robot in sorted({*evidence.orders, *evidence.poses}):
        for t_s, order in evidence.orders[robot]:
            breach = _judge_order(evidence, paths, tolerance, t_s, order)
            breaches.extend([(t_s, breach)] if breach is not None else [])
        breaches.extend(_judge_motion(evidence.poses[robot], evidence.orders[robot], tolerance))
    for robot, grants in evidence.grants.items():
        breaches.extend(_judge_grants(robot, grants))
    breaches.extend(judge_one_at_a_time(evidence))
    return sorted(breaches, key=lambda breach: breach[0])


def _judge_order(
    evidence: Evidence,
    paths: Paths,
    tolerance: Tolerance,
    t_s: float,
    order: OrderAccepted,
) -> PromiseBroken | None:
    joins = order.epoch in evidence.lining_up
    if order.target is None or joins:
        return _judge_planned(evidence.plans[order.robot], t_s, order, joins=joins)
    strand = evidence.strands.get((order.robot, order.epoch))
    path = paths.of(strand) if strand is not None else None
    if strand is None or path is None or order.robot not in strand.order:
        return _breach(order.robot, order.reach_m, 0.0, f"ordered in epoch {order.epoch} without a strand")
    place = strand.order.index(order.robot)
    if place == 0 and (order.step > 0 or order.epoch - 1 in evidence.lining_up):
        return _judge_planned(evidence.plans[order.robot], t_s, order, joins=False)
    if place == 0:
        laid = paths.laid(strand.order, order.epoch)
        granted_m, excused, granter = 0.0 if laid is None else laid.end_m, False, "the strand's path"
    else:
        granted_m, excused = _granted(evidence, strand.order[place - 1], t_s, order)
        granter = f"robot {strand.order[place - 1]} granted"
    if order.reach_m > granted_m + ROUNDING_M and not excused:
        return _breach(order.robot, order.reach_m, granted_m, f"ordered further than {granter}")
    beside_m = apart_m(order.target, path.at(order.reach_m))
    allowed_m = tolerance.mu0_m + tolerance.drive_m(
        math.hypot(order.target.x_m - order.x_m, order.target.y_m - order.y_m)
    )
    if beside_m > allowed_m and not excused:
        return _breach(order.robot, beside_m, allowed_m, "ordered beside the strand's path")
    return None


def _granted(evidence: Evidence, ahead: int, t_s: float, order: OrderAccepted) -> tuple[float, bool]:
    """The grant of the robot ahead by then, and whether rule 4 excuses an order beyond it."""
    grants = evidence.granted[ahead, order.robot, order.epoch]
    by_then = bisect_right(grants, t_s + ROUNDING_S, key=itemgetter(0))
    return grants[by_then - 1][1] if by_then else 0.0, evidence.may_have_said_more(ahead, t_s)


def _judge_grants(
    robot: int, grants: Sequence[tuple[float, AuthorityGranted]]
) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 5, for all grants of one robot."""
    granted_m: defaultdict[tuple[int, int], float] = defaultdict(float)
    for t_s, grant in grants:
        link = (grant.to, grant.epoch)
        if grant.authority_m < granted_m[link] - ROUNDING_M:
            why = f"took back what it had granted robot {grant.to}"
            yield t_s, _breach(robot, grant.authority_m, granted_m[link], why)
        granted_m[link] = max(granted_m[link], grant.authority_m)


def _judge_planned(
    plans: Sequence[tuple[float, StepPlanned]], t_s: float, order: OrderAccepted, *, joins: bool
) -> PromiseBroken | None:
    """Rules 2 and 6. An order to stand is always lawful."""
    if order.target is None:
        return None
    by_then = [plan for at_s, plan in plans if at_s <= t_s + ROUNDING_S and plan.epoch == order.epoch]
    planned = [plan for plan in by_then if joins or plan.step == order.step]
    miss_m = min((apart_m(order.target, plan.target) for plan in planned), default=math.inf)
    if miss_m <= ROUNDING_M:
        return None
    step, does = ("any step", "joined") if joins else (f"step {order.step}", "led")
    why = f"ordered elsewhere than {step} was planned" if planned else f"{does} without a planned step"
    return _breach(order.robot, miss_m if planned else order.reach_m, 0.0, why)


def _judge_motion(
    poses: Sequence[tuple[float, PoseSampled]], orders: Orders, tolerance: Tolerance
) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 3, between samples; a motion that stays unlawful is one violation."""
    origins = _origins(orders)
    taken_s = [t_s for t_s, _ in orders]
    lawful = True
    for (start_s, start), (end_s, end) in pairwise(poses):
        moved_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
        if moved_m <= ROUNDING_M:
            continue
        in_hand = bisect_right(taken_s, start_s + ROUNDING_S) - 1
        target = orders[in_hand][1].target if in_hand >= 0 else None
        if target is None:
            breach = _breach(start.robot, moved_m, 0.0, "moved with no order in hand")
        else:
            origin = origins[in_hand]
            beside_m = max(_beside_m(origin, target, start), _beside_m(origin, target, end))
            allowed_m = tolerance.drive_m(apart_m(origin, target))
            reach_m = tolerance.speed_mps_max * (end_s - start_s) + ROUNDING_M
            if beside_m > allowed_m:
                breach = _breach(start.robot, beside_m, allowed_m, "moved off the line to its target")
            elif moved_m > reach_m:
                breach = _breach(start.robot, moved_m, reach_m, "moved faster than it can")
            else:
                lawful = True
                continue
        if lawful:
            yield end_s, breach
        lawful = False


def _origins(orders: Orders) -> list[Point]:
    """Where the body began each drive; successive orders with the same target are one drive."""
    origins: list[Point] = []
    for index, (_, order) in enumerate(orders):
        same = index > 0 and order.target is not None and orders[index - 1][1].target == order.target
        origins.append(origins[-1] if same else Point(x_m=order.x_m, y_m=order.y_m))
    return origins


def _breach(robot: int, measured_m: float, required_m: float, why: str) -> PromiseBroken:
    return PromiseBroken(invariant="S3", robot=robot, measured_m=measured_m, required_m=required_m, why=why)


def _beside_m(start: Point, end: Point, place: PoseSampled) -> float:
    """The distance of a place from the segment between two points."""
    east_m, north_m = end.x_m - start.x_m, end.y_m - start.y_m
    square = east_m * east_m + north_m * north_m
    along = (place.x_m - start.x_m) * east_m + (place.y_m - start.y_m) * north_m
    share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(place.x_m - start.x_m - share * east_m, place.y_m - start.y_m - share * north_m)
