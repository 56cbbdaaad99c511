"""The evidence in a timeline: fences, orders, motion, formations, and what robots recorded.

Entries of one source come in order, sources in any order. The world records fences, orders and scans, so the
fence under which a body accepted an order is known at once. All else is judged when all entries are there.
"""

import math
from bisect import bisect_right, insort
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FenceChanged,
    LeaderSucceeded,
    OrderAccepted,
    PoseSampled,
    RobotDied,
    RobotFailed,
    RobotStarted,
    ScanServed,
    StepAbandoned,
    StepPlanned,
    StrandFormed,
    StrandHealed,
    StrandJoined,
    TrafficCounted,
    ViewJoined,
    ViewLeft,
)
from world.judge.fences import Fences

ROUNDING_M = 1e-6  # of sums of arc lengths, computed by one process and checked by another
JOINS = 0  # for all steps of a robot that joins; a leader's count from 1

Told = (
    RobotStarted
    | RobotFailed
    | ViewJoined
    | ViewLeft
    | StrandFormed
    | StrandJoined
    | StrandHealed
    | LeaderSucceeded
    | StepPlanned
    | AuthorityGranted
    | TrafficCounted
)


class Taken(NamedTuple):
    """An order that a body accepted."""

    t_s: float
    order: OrderAccepted
    fence: int
    """The fence in force then."""
    scanned: int | None
    """The fence in force when the body was last scanned; None: never."""


@dataclass(frozen=True, slots=True)
class Formed:
    """A formation, as a robot recorded it."""

    t_s: float
    by: int
    strand: StrandFormed
    ranks: Mapping[int, int]
    """The rank of each member; the leader's is 0."""

    def is_behind(self, robot: int, other: int) -> bool:
        """Whether a robot is a member directly behind another."""
        members = robot in self.ranks and other in self.ranks
        return members and self.ranks[robot] == self.ranks[other] + 1


@dataclass(slots=True)
class Evidence:
    """The relevant entries of a timeline with their times, by robot and in order."""

    fences: Fences = field(default_factory=Fences)
    orders: dict[int, list[Taken]] = field(default_factory=lambda: defaultdict(list))
    poses: dict[int, list[tuple[float, PoseSampled]]] = field(default_factory=lambda: defaultdict(list))
    told: dict[int, list[tuple[float, Told]]] = field(default_factory=lambda: defaultdict(list))
    granted: dict[tuple[int, int, int], list[tuple[float, float]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    """The largest authority by then, by granter, grantee and epoch."""
    plans: dict[tuple[int, int], dict[int, list[tuple[float, StepPlanned]]]] = field(
        default_factory=lambda: defaultdict(partial(defaultdict, list))
    )
    """By robot and epoch, then by the leader's step, or `JOINS`."""
    abandoned: dict[tuple[int, int], dict[int, Point]] = field(default_factory=lambda: defaultdict(dict))
    """Where abandoned steps ended, by robot and epoch."""
    formed: dict[int, Formed] = field(default_factory=dict)
    """The first formation recorded of each epoch."""
    formed_again: list[Formed] = field(default_factory=list)
    holes: list[tuple[float, int, int]] = field(default_factory=list)
    """Gaps in the entry numbers of a robot: time, robot, next number."""
    _heard_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    """The times of each robot's entries, sorted: a new process does not know the time yet."""
    _deaths_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    _counts: dict[int, int] = field(default_factory=dict)
    _scanned: dict[int, int] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry."""
        robot = robot_number(source)
        if source == WORLD:
            self._hear_world(entry)
        elif robot is not None:
            self._hear_number(robot, entry)
            self._hear_robot(robot, entry)

    def _hear_world(self, entry: Entry) -> None:
        t_s = entry.t_s
        match entry.record:
            case FenceChanged() as change:
                self.fences.hear(t_s, change)
            case OrderAccepted(robot=robot) as order:
                taken = Taken(t_s, order, self.fences.newest, self._scanned.get(robot))
                self.orders[robot].append(taken)
            case PoseSampled(robot=robot) as pose:
                self.poses[robot].append((t_s, pose))
            case ScanServed(robot=robot):
                self._scanned[robot] = self.fences.newest
            case RobotDied(robot=robot):
                self._deaths_s[robot].append(t_s)
            case _:
                pass  # irrelevant for the judgement

    def _hear_number(self, robot: int, entry: Entry) -> None:
        if entry.n not in {self._counts.get(robot, 0) + 1, 1}:  # a new process counts from 1
            self.holes.append((entry.t_s, robot, entry.n))
        self._counts[robot] = entry.n
        insort(self._heard_s[robot], entry.t_s)

    def _hear_robot(self, robot: int, entry: Entry) -> None:
        t_s, record = entry.t_s, entry.record
        if isinstance(record, Told):
            self.told[robot].append((t_s, record))
        match record:
            case AuthorityGranted() as grant:
                granted = self.granted[robot, grant.to, grant.epoch]
                granted.append((t_s, max(grant.authority_m, granted[-1][1] if granted else 0.0)))
            case StepPlanned() as plan:
                self.plans[robot, plan.epoch][JOINS if plan.joins else plan.step].append((t_s, plan))
            case StepAbandoned() as step:
                self.abandoned[robot, step.epoch][step.step] = Point(x_m=step.x_m, y_m=step.y_m)
            case StrandFormed() as strand:
                formed = Formed(t_s, robot, strand, {each: rank for rank, each in enumerate(strand.order)})
                if self.formed.setdefault(strand.epoch, formed) is not formed:
                    self.formed_again.append(formed)
            case _:
                pass  # told, or irrelevant

    def may_have_said_more(self, robot: int, t_s: float, *, since_s: float | None = None) -> bool:
        """Whether entries of a robot up to this time may be missing, because its process was killed.

        It died later, and nothing that it recorded in between has arrived.

        Args:
            robot: the robot.
            t_s: the time.
            since_s: a message of the robot may have arrived long after its death; a death from this time on
                counts too.
        """
        from_s = t_s if since_s is None else since_s
        died_s = next((each_s for each_s in self._deaths_s.get(robot, ()) if each_s >= from_s), None)
        if died_s is None:
            return False
        heard_s = self._heard_s.get(robot, [])
        return died_s < t_s or bisect_right(heard_s, t_s) == bisect_right(heard_s, died_s)

    def place_at(self, robot: int, t_s: float) -> Point | None:
        """Where a body was; None if it was never sampled."""
        poses = self.poses.get(robot)
        if not poses:
            return None
        after = bisect_right(poses, t_s, key=lambda each: each[0])
        if after in {0, len(poses)}:
            pose = poses[max(after - 1, 0)][1]
            return Point(x_m=pose.x_m, y_m=pose.y_m)
        (start_s, start), (end_s, end) = poses[after - 1], poses[after]
        share = (t_s - start_s) / (end_s - start_s)
        return Point(
            x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m)
        )


def apart_m(one: Point | PoseSampled, other: Point | PoseSampled) -> float:
    """The distance between two places."""
    return math.hypot(other.x_m - one.x_m, other.y_m - one.y_m)
