"""Coverage counters for the schedules of an adversary, counted from a timeline. Pure.

Rule 1: a robot's clock is its newest odometry. The number of odometry messages lost in a row says how long
        the clock stood still.
Rule 2: an order belongs to a former life if its number is lower than any that the new life can use.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from agents.body.driver import LATE_ORDERS
from clew.coverage.situations import Situation
from clew.rehearsal.tokens import LEASE_S
from protocol.faults.plan import Plan
from protocol.faults.rules import ROUTER, Partition
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    FaultInjected,
    OrderAccepted,
    OrderRefused,
    Record,
    StrandFormed,
)
from world.bodies.arena import ODOMETRY_TICKS, TICK_S

ODOMETRY_PERIOD_S = ODOMETRY_TICKS * TICK_S
SOON_S = 1.0  # a lease of a token or a dead-man stop: a later event is not a consequence
JUST_S = 5.0  # until a restarted robot asks to be let in


@dataclass(slots=True)
class _Robot:
    """What is known of one robot."""

    back_s: float | None = None
    """When its token came back after a cut from the router."""
    still_s: float = 0.0
    """When its clock last stood still; then how many odometry messages it missed, and the last one's time."""
    missed: int = 0
    noted_s: float = 0.0
    ordered: int = 0
    """The number of the newest order that its body has accepted."""
    former: int = 0
    """Orders up to this number belong to a former life."""
    killed_s: float | None = None
    started_s: float | None = None
    has_ordered: bool = True
    """Whether an order of its newest life has arrived."""

    def lags(self, now_s: float) -> bool:
        """Whether its clock stands still (rule 1)."""
        next_s = self.still_s + (self.missed + 1) * ODOMETRY_PERIOD_S
        return self.missed > 0 and self.still_s <= now_s < next_s


@dataclass(slots=True)
class Adversary:
    """What is known so far; calls `count` for each situation."""

    plan: Plan
    count: Callable[[Situation], None]
    _robots: dict[int, _Robot] = field(default_factory=dict)
    _order: tuple[int, ...] = ()
    _world_is_down: bool = False

    def hear(self, source: str, t_s: float, record: Record) -> None:
        """Read the next entry."""
        robot = robot_number(source)
        match record:
            case FaultInjected(fault=fault, process=str(process)) if source == WORLD:
                self._hear_process_fault(t_s, fault, process)
            case OrderAccepted(robot=body, number=number):
                self._hear_order(body, number, t_s, refused=False)
            case OrderRefused(robot=body, number=number):
                self._hear_order(body, number, t_s, refused=True)
            case FaultInjected() if robot is not None:
                self._hear_loss(robot, t_s, record)
            case StrandFormed(order=order):
                self._order = order
            case _:
                pass

    def _of(self, robot: int) -> _Robot:
        return self._robots.setdefault(robot, _Robot())

    def _hear_process_fault(self, t_s: float, fault: str, process: str) -> None:
        robot = robot_number(process)
        if process == WORLD:
            self._world_is_down = fault == "kill" or (self._world_is_down and fault != "start")
        elif robot is not None and fault == "kill":
            self._kill(robot, t_s)
        elif robot is not None and fault == "start":
            life = self._of(robot)
            life.former, life.started_s, life.has_ordered = life.ordered + LATE_ORDERS, t_s, False
            died_s = [self._of(other).killed_s for other in self._neighbours(robot)]
            if any(at_s is not None and at_s >= (life.killed_s or 0.0) for at_s in died_s):
                self.count(Situation.KILLED_BESIDE_RESTARTED)
            life.killed_s = None

    def _kill(self, robot: int, t_s: float) -> None:
        if self._world_is_down:
            self.count(Situation.KILLED_UNSEEN)
        if any(each.lags(t_s) for other, each in self._robots.items() if other != robot):
            self.count(Situation.LAGGED_AT_DEATH)
        started_s = [self._of(other).started_s for other in self._neighbours(robot)]
        if any(at_s is not None and t_s - at_s <= JUST_S for at_s in started_s):
            self.count(Situation.KILLED_BESIDE_RESTARTED)
        self._of(robot).killed_s = t_s

    def _neighbours(self, robot: int) -> Sequence[int]:
        if robot not in self._order:
            return ()
        place = self._order.index(robot)
        return [self._order[each] for each in (place - 1, place + 1) if 0 <= each < len(self._order)]

    def _hear_order(self, robot: int, number: int, t_s: float, *, refused: bool) -> None:
        """Count orders of a former life, and late first orders (rule 2)."""
        life = self._of(robot)
        if life.started_s is not None and number <= life.former:
            self.count(Situation.FORMER_ORDER_REFUSED if refused else Situation.FORMER_ORDER)
            return
        if not life.has_ordered and life.started_s is not None and t_s - life.started_s > SOON_S:
            self.count(Situation.BEGAN_BLIND)
        life.has_ordered = True
        if not refused:
            life.ordered = max(life.ordered, number)

    def _hear_loss(self, receiver: int, t_s: float, record: FaultInjected) -> None:
        key = record.key or ""
        if key.startswith("body/") and key.endswith("/odometry"):
            self._miss(self._of(receiver), t_s, record)
        sender = robot_number(key.split("/")[1]) if key.startswith(("view/", "link/")) else None
        if record.fault != "partition" or sender is None or self._is_from_router(record.rule):
            return
        back_s = self._of(sender).back_s
        if back_s is not None and back_s <= t_s <= back_s + SOON_S:
            self._of(sender).back_s = None
            self.count(Situation.BACK_WHILE_CUT)

    def _miss(self, robot: _Robot, t_s: float, record: FaultInjected) -> None:
        if record.fault not in {"drop", "delay", "partition"}:
            return
        if robot.missed == 0 or t_s - robot.noted_s > 1.5 * ODOMETRY_PERIOD_S:
            robot.missed, robot.still_s = 0, t_s
        robot.missed, robot.noted_s = robot.missed + 1, t_s
        away_s = robot.missed * ODOMETRY_PERIOD_S
        if away_s > LEASE_S and self._is_from_router(record.rule):
            robot.back_s = robot.still_s + away_s

    def _is_from_router(self, name: str) -> bool:
        rules = [rule for rule in self.plan.rules if isinstance(rule, Partition) and rule.name == name]
        return any(ROUTER in (*rule.group, *rule.others) for rule in rules)
