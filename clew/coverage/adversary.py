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

    def die(self, t_s: float) -> None:
        """Its life ends."""
        self.killed_s = t_s

    def start(self, t_s: float) -> None:
        """A new life begins, of which no order has arrived yet (rule 2)."""
        self.former, self.started_s = self.ordered + LATE_ORDERS, t_s
        self.has_ordered, self.killed_s = False, None

    def order(self, number: int, *, refused: bool) -> None:
        """An order of its newest life has arrived."""
        self.has_ordered = True
        if not refused:
            self.ordered = max(self.ordered, number)

    def miss(self, t_s: float) -> float:
        """One more odometry message is lost; returns for how long the clock has stood still (rule 1)."""
        if self.missed == 0 or t_s - self.noted_s > 1.5 * ODOMETRY_PERIOD_S:
            self.missed, self.still_s = 0, t_s
        self.missed, self.noted_s = self.missed + 1, t_s
        return self.missed * ODOMETRY_PERIOD_S

    def come_back(self, away_s: float) -> None:
        """It was cut from the router for so long that its token went: that comes back after the cut."""
        self.back_s = self.still_s + away_s

    def speaks_once(self, t_s: float) -> bool:
        """Whether its token has just come back; each return counts once."""
        has_come = self.back_s is not None and self.back_s <= t_s <= self.back_s + SOON_S
        self.back_s = None if has_come else self.back_s
        return has_come

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
            died_s = [self._of(other).killed_s for other in self._neighbours(robot)]
            if any(at_s is not None and at_s >= (life.killed_s or 0.0) for at_s in died_s):
                self.count(Situation.KILLED_BESIDE_RESTARTED)
            life.start(t_s)

    def _kill(self, robot: int, t_s: float) -> None:
        if self._world_is_down:
            self.count(Situation.KILLED_UNSEEN)
        if any(each.lags(t_s) for other, each in self._robots.items() if other != robot):
            self.count(Situation.LAGGED_AT_DEATH)
        started_s = [self._of(other).started_s for other in self._neighbours(robot)]
        if any(at_s is not None and t_s - at_s <= JUST_S for at_s in started_s):
            self.count(Situation.KILLED_BESIDE_RESTARTED)
        self._of(robot).die(t_s)

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
        life.order(number, refused=refused)

    def _hear_loss(self, receiver: int, t_s: float, record: FaultInjected) -> None:
        key = record.key or ""
        if key.startswith("body/") and key.endswith("/odometry"):
            self._miss(self._of(receiver), t_s, record)
        sender = robot_number(key.split("/")[1]) if key.startswith(("view/", "link/")) else None
        if record.fault != "partition" or sender is None or self._is_from_router(record.rule):
            return
        if self._of(sender).speaks_once(t_s):
            self.count(Situation.BACK_WHILE_CUT)

    def _miss(self, robot: _Robot, t_s: float, record: FaultInjected) -> None:
        if record.fault not in {"drop", "delay", "partition"}:
            return
        away_s = robot.miss(t_s)
        if away_s > LEASE_S and self._is_from_router(record.rule):
            robot.come_back(away_s)

    def _is_from_router(self, name: str) -> bool:
        rules = [rule for rule in self.plan.rules if isinstance(rule, Partition) and rule.name == name]
        return any(ROUTER in (*rule.group, *rule.others) for rule in rules)
