"""The evidence in a timeline: orders, motion, grants and plans; `paths` derives the strands' paths."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from protocol.frames import Point
from protocol.keys import WORLD, robot_number
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

ROUNDING_M = 1e-6  # of sums of arc lengths, computed by one process and checked by another
ROUNDING_S = 1e-9

Orders = Sequence[tuple[float, OrderAccepted]]


@dataclass(slots=True)
class Evidence:
    """Orders, motion, grants and plans of a timeline: each with its time, by robot."""

    orders: dict[int, list[tuple[float, OrderAccepted]]] = field(default_factory=lambda: defaultdict(list))
    poses: dict[int, list[tuple[float, PoseSampled]]] = field(default_factory=lambda: defaultdict(list))
    grants: dict[int, list[tuple[float, AuthorityGranted]]] = field(default_factory=lambda: defaultdict(list))
    granted: dict[tuple[int, int, int], list[tuple[float, float]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    """The largest authority by then, by granter, grantee and epoch."""
    heard_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    """The times of each robot's entries."""
    plans: dict[int, list[tuple[float, StepPlanned]]] = field(default_factory=lambda: defaultdict(list))
    strands: dict[tuple[int, int], StrandFormed] = field(default_factory=dict)
    """By robot and epoch."""
    reversals: dict[int, StrandReversed] = field(default_factory=dict)
    """By the epoch that ended."""
    lining_up: set[int] = field(default_factory=lambda: {0})
    """The epochs in which robots lined up."""
    abandoned: dict[tuple[int, int], dict[int, Point]] = field(default_factory=lambda: defaultdict(dict))
    """Where abandoned steps ended, by robot and epoch."""
    deaths_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    history: History = field(default_factory=History)
    """Further facts from the same entries."""

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry; the entries of one source come in order, sources in any order."""
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
                pass  # irrelevant for authority

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
                pass  # irrelevant for authority

    def may_have_said_more(self, robot: int, t_s: float) -> bool:
        """Whether a robot died later and recorded nothing in between."""
        died = next((died_s for died_s in self.deaths_s[robot] if died_s >= t_s), None)
        if died is None:
            return False
        return not any(t_s < at_s <= died for at_s in self.heard_s[robot])


def apart_m(one: Point, other: Point) -> float:
    """The distance between two places."""
    return math.hypot(other.x_m - one.x_m, other.y_m - one.y_m)
