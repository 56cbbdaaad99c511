"""S3, no body moves without authority, judged from a run's timeline alone.

Rule 1: a robot that follows is ordered only to a place of the strand's path, and no further along it than
        the robot ahead had granted it in that epoch by then. A granter's clock is never ahead of the
        world's, so a grant that is dated later than the order came too late, whenever it was recorded.
Rule 2: the leader is ordered only to the target of a switching step that it had planned.
Rule 3: a body moves only with an order in hand, straight from where it took it towards its target, and no
        faster than it can.
Rule 4: the strand's path is the polyline of the places where the robots lined up just before, tail first (of
        the path between them, where they had stayed in a strand), and then of the targets of the leader's
        switching steps. When the strand has turned round, it is what there was the other way, and then the
        new leader's targets; along what there was its first may drive.
Rule 5: where the robot ahead died, its last grants may have died with it: then rule 1 is not held against
        an order from between its last entry and its death, which only those could have allowed.
Rule 6: what a robot has granted it never takes back within the epoch: who was granted it may be there.
Rule 7: while they line up, in epoch 0, in the one after a strand has dissolved, and in one that was called, a
        robot is ordered only to the target of a step that it had planned, and while its body drives there, no
        other moves. Nor does any robot while one moves by the orders of another call.
"""

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from operator import itemgetter

from protocol.epochs import of_one_call
from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.path import Path
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    MusterCalled,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    RobotDied,
    StepAbandoned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandReversed,
)
from world.history import History

ROUNDING_M = 1e-6  # of sums of arc lengths, added up by one process and checked by another
ROUNDING_S = 1e-9

Orders = Sequence[tuple[float, OrderAccepted]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """How far beside its line a body may be."""

    mu0_m: float
    heading_error_rad: float
    speed_mps_max: float

    def drive_m(self, length_m: float) -> float:
        """What the drive error makes of so many metres."""
        return ROUNDING_M + self.heading_error_rad * length_m


@dataclass(slots=True)
class Evidence:
    """What a timeline says about orders, motion, grants and plans: each with its time, by robot."""

    orders: dict[int, list[tuple[float, OrderAccepted]]] = field(default_factory=lambda: defaultdict(list))
    poses: dict[int, list[tuple[float, PoseSampled]]] = field(default_factory=lambda: defaultdict(list))
    grants: dict[int, list[tuple[float, AuthorityGranted]]] = field(default_factory=lambda: defaultdict(list))
    granted: dict[tuple[int, int, int], list[tuple[float, float]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    """The largest authority by then, by granter, grantee and epoch."""
    heard_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    """When each robot recorded its entries."""
    plans: dict[int, list[tuple[float, StepPlanned]]] = field(default_factory=lambda: defaultdict(list))
    strands: dict[tuple[int, int], StrandFormed] = field(default_factory=dict)
    """By robot and epoch."""
    reversals: dict[int, StrandReversed] = field(default_factory=dict)
    """By the epoch that each ended."""
    lining_up: set[int] = field(default_factory=lambda: {0})
    """The epochs in which robots lined up."""
    abandoned: dict[tuple[int, int], dict[int, Point]] = field(default_factory=lambda: defaultdict(dict))
    """Where the steps ended that were given up, by robot and epoch."""
    deaths_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    history: History = field(default_factory=History)
    """What the same entries say beside."""

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in; those of one source come in their order, sources in any."""
        robot = robot_number(source)
        self.history.hear(source, entry)
        if source == WORLD:
            self._hear_world(entry)
        elif robot is not None:
            self.heard_s[robot].append(entry.t_s)
            self._hear_robot(robot, entry)

    def _hear_world(self, entry: Entry) -> None:
        match entry.record:
            case OrderAccepted() as order:
                self.orders[order.robot].append((entry.t_s, order))
            case PoseSampled() as pose:
                self.poses[pose.robot].append((entry.t_s, pose))
            case RobotDied() as death:
                self.deaths_s[death.robot].append(entry.t_s)
            case _:
                pass  # the rest says nothing about authority

    def _hear_robot(self, robot: int, entry: Entry) -> None:
        match entry.record:
            case AuthorityGranted() as grant:
                self.grants[robot].append((entry.t_s, grant))
                granted = self.granted[robot, grant.to, grant.epoch]
                granted.append((entry.t_s, max(grant.authority_m, granted[-1][1] if granted else 0.0)))
            case StepPlanned() as plan:
                self.plans[robot].append((entry.t_s, plan))
            case StepAbandoned() as step:
                self.abandoned[robot, step.epoch][step.step] = Point(x_m=step.x_m, y_m=step.y_m)
            case StrandFormed() as strand:
                self.strands[robot, strand.epoch] = strand
            case StrandReversed() as reversal:
                self.reversals[reversal.epoch] = reversal
            case StrandDissolved(epoch=epoch):
                self.lining_up.add(epoch + 1)
            case MusterCalled(epoch=epoch):
                self.lining_up.add(epoch)
            case _:
                pass  # the rest says nothing about authority

    def path(self, strand: StrandFormed) -> Path | None:
        """The strand's path, rule 4; None where a robot of it was never seen, or it never turned round."""
        if not all(robot in self.poses for robot in strand.order):
            return None
        return self._path(strand.order, strand.epoch)

    def _path(self, order: tuple[int, ...], epoch: int) -> Path | None:
        path = self.laid(order, epoch)
        targets = {plan.step: plan.target for _, plan in self.plans[order[0]] if plan.epoch == epoch}
        targets |= self.abandoned[order[0], epoch]
        for step in sorted(targets) if path is not None else []:
            assert path is not None
            path.extend(targets[step])
        return path

    def laid(self, order: tuple[int, ...], epoch: int) -> Path | None:
        """What there was of the strand's path when the epoch began."""
        if epoch - 1 in self.lining_up:
            starts = [self._lined_up_at(robot, epoch) for robot in reversed(order)]
            path = Path(Point(x_m=start.x_m, y_m=start.y_m) for start in starts)
            formed = self.strands.get((order[0], epoch))
            bent = Path(formed.laid) if formed is not None and formed.laid else None
            # What a leader says of its path counts only where it begins and ends as the robots stood.
            both = bent is not None and all(
                _apart_m(path.at(end), bent.at(end)) <= ROUNDING_M for end in (0.0, math.inf)
            )
            return bent if both else path
        reversal = self.reversals.get(epoch - 1)
        before = None if reversal is None else self._path(tuple(reversed(order)), epoch - 1)
        return None if reversal is None or before is None else before.reversed(reversal.cut_m, reversal.end_m)

    def may_have_said_more(self, robot: int, t_s: float) -> bool:
        """Rule 5: whether a robot died soon after, and had recorded nothing since."""
        died = next((died_s for died_s in self.deaths_s[robot] if died_s >= t_s), None)
        if died is None:
            return False
        return not any(t_s < at_s <= died for at_s in self.heard_s[robot])

    def _lined_up_at(self, robot: int, epoch: int) -> OrderAccepted | PoseSampled:
        """Where a robot stood when the strand formed: where its first order from then on found it."""
        first = (order for _, order in self.orders[robot] if order.epoch >= epoch)
        return next(first, self.poses[robot][-1][1])


def judge_authority(evidence: Evidence, tolerance: Tolerance) -> list[tuple[float, PromiseBroken]]:
    """Every breach of S3 with its time, each order and each unlawful motion once."""
    paths: dict[StrandFormed, Path | None] = {
        strand: evidence.path(strand) for strand in set(evidence.strands.values())
    }
    breaches: list[tuple[float, PromiseBroken]] = []
    for robot in sorted({*evidence.orders, *evidence.poses}):
        for t_s, order in evidence.orders[robot]:
            breach = _judge_order(evidence, paths, tolerance, t_s, order)
            breaches.extend([(t_s, breach)] if breach is not None else [])
        breaches.extend(_judge_motion(evidence.poses[robot], evidence.orders[robot], tolerance))
    for robot, grants in evidence.grants.items():
        breaches.extend(_judge_grants(robot, grants))
    breaches.extend(_judge_joining(evidence))
    breaches.extend(_judge_calls(evidence))
    return sorted(breaches, key=lambda breach: breach[0])


def _judge_order(
    evidence: Evidence,
    paths: dict[StrandFormed, Path | None],
    tolerance: Tolerance,
    t_s: float,
    order: OrderAccepted,
) -> PromiseBroken | None:
    joins = order.epoch in evidence.lining_up
    if order.target is None or joins:
        return _judge_planned(evidence.plans[order.robot], t_s, order, joins=joins)
    strand = evidence.strands.get((order.robot, order.epoch))
    path = paths[strand] if strand is not None else None
    if strand is None or path is None or order.robot not in strand.order:
        return _breach(order.robot, order.reach_m, 0.0, f"ordered in epoch {order.epoch} without a strand")
    place = strand.order.index(order.robot)
    if place == 0 and (order.step > 0 or order.epoch - 1 in evidence.lining_up):
        return _judge_planned(evidence.plans[order.robot], t_s, order, joins=False)
    if place == 0:
        laid = evidence.laid(strand.order, order.epoch)
        granted_m, excused, granter = 0.0 if laid is None else laid.end_m, False, "the strand's path"
    else:
        granted_m, excused = _granted(evidence, strand.order[place - 1], t_s, order)
        granter = f"robot {strand.order[place - 1]} granted"
    if order.reach_m > granted_m + ROUNDING_M and not excused:
        return _breach(order.robot, order.reach_m, granted_m, f"ordered further than {granter}")
    beside_m = _apart_m(order.target, path.at(order.reach_m))
    allowed_m = tolerance.mu0_m + tolerance.drive_m(
        math.hypot(order.target.x_m - order.x_m, order.target.y_m - order.y_m)
    )
    if beside_m > allowed_m and not excused:
        return _breach(order.robot, beside_m, allowed_m, "ordered beside the strand's path")
    return None


def _granted(evidence: Evidence, ahead: int, t_s: float, order: OrderAccepted) -> tuple[float, bool]:
    """What the robot ahead had granted by then, and whether rule 5 excuses an order beyond."""
    grants = evidence.granted[ahead, order.robot, order.epoch]
    by_then = bisect_right(grants, t_s + ROUNDING_S, key=itemgetter(0))
    return grants[by_then - 1][1] if by_then else 0.0, evidence.may_have_said_more(ahead, t_s)


def _judge_grants(
    robot: int, grants: Sequence[tuple[float, AuthorityGranted]]
) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 6, over all that one robot granted."""
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
    """Rules 2 and 7. To stand still is always lawful."""
    if order.target is None:
        return None
    by_then = [plan for at_s, plan in plans if at_s <= t_s + ROUNDING_S and plan.epoch == order.epoch]
    planned = [plan for plan in by_then if joins or plan.step == order.step]
    miss_m = min((_apart_m(order.target, plan.target) for plan in planned), default=math.inf)
    if miss_m <= ROUNDING_M:
        return None
    step, does = ("any step", "joined") if joins else (f"step {order.step}", "led")
    why = f"ordered elsewhere than {step} was planned" if planned else f"{does} without a planned step"
    return _breach(order.robot, miss_m if planned else order.reach_m, 0.0, why)


def _judge_joining(evidence: Evidence) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 7: who moved while another joined, once for each two robots."""
    if not evidence.lining_up.intersection(_epochs(evidence)):
        return
    drives = [drive for robot in evidence.poses for drive in _drives(evidence, robot)]
    longest = longest_joining = _Drive(-math.inf, -math.inf, 0, False, 0.0, 0)
    accused: set[tuple[int, int]] = set()
    for drive in sorted(drives, key=lambda drive: drive.start_s):
        other = longest if drive.joins else longest_joining
        two = (drive.robot, other.robot)
        if other.end_s > drive.start_s + ROUNDING_S and two not in accused:
            accused.add(two)
            why = f"moved while robot {other.robot} did, before the strand had formed"
            yield drive.start_s, _breach(drive.robot, drive.moved_m, 0.0, why)
        longest = max(longest, drive, key=lambda each: each.end_s)
        if drive.joins:
            longest_joining = max(longest_joining, drive, key=lambda each: each.end_s)


def _judge_calls(evidence: Evidence) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 7: who moved while another did by the orders of another call, once for each two robots."""
    epochs = _epochs(evidence)
    if not epochs or of_one_call(min(epochs), max(epochs)):
        return
    drives = [drive for robot in evidence.poses for drive in _drives(evidence, robot)]
    newest: dict[int, _Drive] = {}  # of each call, the motion that ends last
    accused: set[tuple[int, int]] = set()
    for drive in sorted(drives, key=lambda drive: drive.start_s):
        for call, other in newest.items():
            two = (drive.robot, other.robot)
            if of_one_call(call, drive.epoch) or other.end_s <= drive.start_s + ROUNDING_S or two in accused:
                continue
            accused.add(two)
            why = f"moved while robot {other.robot} did, by the orders of another call"
            yield drive.start_s, _breach(drive.robot, drive.moved_m, 0.0, why)
        same = next((call for call in newest if of_one_call(call, drive.epoch)), drive.epoch)
        newest[same] = max(newest.get(same, drive), drive, key=lambda each: each.end_s)


@dataclass(frozen=True, slots=True)
class _Drive:
    """A motion between two samples."""

    start_s: float
    end_s: float
    robot: int
    joins: bool
    moved_m: float
    epoch: int


def _epochs(evidence: Evidence) -> set[int]:
    """The epochs of all orders."""
    return {order.epoch for each in evidence.orders.values() for _, order in each}


def _drives(evidence: Evidence, robot: int) -> Iterator[_Drive]:
    """All motions of a body."""
    orders = evidence.orders[robot]
    lining_up = evidence.lining_up
    taken_s = [t_s for t_s, _ in orders]
    for (start_s, start), (end_s, end) in pairwise(evidence.poses[robot]):
        moved_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
        if moved_m > ROUNDING_M:
            in_hand = bisect_right(taken_s, start_s + ROUNDING_S) - 1
            joins = in_hand >= 0 and orders[in_hand][1].epoch in lining_up
            epoch = orders[in_hand][1].epoch if in_hand >= 0 else 0
            yield _Drive(start_s, end_s, robot, joins, moved_m, epoch)


def _judge_motion(
    poses: Sequence[tuple[float, PoseSampled]], orders: Orders, tolerance: Tolerance
) -> Iterator[tuple[float, PromiseBroken]]:
    """Rule 3, between each two samples; a motion that stays unlawful is one breach."""
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
            allowed_m = tolerance.drive_m(_apart_m(origin, target))
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
    """Where the body began to drive to each order's target: orders with one target are one drive."""
    origins: list[Point] = []
    for index, (_, order) in enumerate(orders):
        same = index > 0 and order.target is not None and orders[index - 1][1].target == order.target
        origins.append(origins[-1] if same else Point(x_m=order.x_m, y_m=order.y_m))
    return origins


def _breach(robot: int, measured_m: float, required_m: float, why: str) -> PromiseBroken:
    return PromiseBroken(invariant="S3", robot=robot, measured_m=measured_m, required_m=required_m, why=why)


def _apart_m(one: Point, other: Point) -> float:
    return math.hypot(other.x_m - one.x_m, other.y_m - one.y_m)


def _beside_m(start: Point, end: Point, place: PoseSampled) -> float:
    """How far a place is from the line between two points."""
    east_m, north_m = end.x_m - start.x_m, end.y_m - start.y_m
    square = east_m * east_m + north_m * north_m
    along = (place.x_m - start.x_m) * east_m + (place.y_m - start.y_m) * north_m
    share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(place.x_m - start.x_m - share * east_m, place.y_m - start.y_m - share * north_m)
