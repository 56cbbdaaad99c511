"""What a timeline says about orders, motion, grants and plans, and the paths of strands that follow from it.

Rule 1: the strand's path is the polyline of the places where the robots lined up just before, tail first (of
        the path between them, where they had stayed in a strand), and then of the targets of the leader's
        switching steps. When the strand has turned round, it is what there was the other way, and then the
        new leader's targets; along what there was its first may drive.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.path import Path
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    MusterCalled,
    OrderAccepted,
    PoseSampled,
    RobotDied,
    StepAbandoned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandReversed,
)
from world.judge.history import History

ROUNDING_M = 1e-6  # of sums of arc lengths, added up by one process and checked by another
ROUNDING_S = 1e-9

Orders = Sequence[tuple[float, OrderAccepted]]


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
        """The strand's path, rule 1; None where a robot of it was never seen, or it never turned round."""
        if not all(self.poses.get(robot) for robot in strand.order):
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
                apart_m(path.at(end), bent.at(end)) <= ROUNDING_M for end in (0.0, math.inf)
            )
            return bent if both else path
        reversal = self.reversals.get(epoch - 1)
        before = None if reversal is None else self._path(tuple(reversed(order)), epoch - 1)
        return None if reversal is None or before is None else before.reversed(reversal.cut_m, reversal.end_m)

    def may_have_said_more(self, robot: int, t_s: float) -> bool:
        """Whether a robot died soon after, and had recorded nothing since."""
        died = next((died_s for died_s in self.deaths_s[robot] if died_s >= t_s), None)
        if died is None:
            return False
        return not any(t_s < at_s <= died for at_s in self.heard_s[robot])

    def _lined_up_at(self, robot: int, epoch: int) -> OrderAccepted | PoseSampled:
        """Where a robot stood when the strand formed: where its first order from then on found it."""
        first = (order for _, order in self.orders[robot] if order.epoch >= epoch)
        return next(first, self.poses[robot][-1][1])


def apart_m(one: Point, other: Point) -> float:
    """The distance between two places."""
    return math.hypot(other.x_m - one.x_m, other.y_m - one.y_m)
