"""Coverage counters: how often rare situations occurred, counted from timelines. Pure.

A campaign proves little about a situation that never occurred in it.

Rule 1: a counter counts what happened, not what a plan contains.
Rule 2: the only input is the timeline, in order of time; so recorded runs can be counted as well.
"""

from collections import Counter
from collections.abc import Iterable, Mapping

from clew.coverage.adversary import Adversary
from clew.coverage.situations import Situation
from clew.coverage.views import Views
from protocol.faults.plan import Plan
from protocol.faults.rules import MessageRule, ProcessRule, StepPoint
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    LinkBroken,
    OrderRefused,
    Record,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    StrandJoined,
    StrandReversed,
    ViewJoined,
)

WAKES_S = 1.0  # within this time after a thaw a robot has not yet received what happened meanwhile


_POINTS = {
    StepPoint.AFTER_SCAN: Situation.KILLED_AFTER_SCAN,
    StepPoint.AFTER_PLAN: Situation.KILLED_AFTER_PLAN,
    StepPoint.MID_DRIVE: Situation.KILLED_MID_DRIVE,
    StepPoint.BEFORE_ACK: Situation.KILLED_BEFORE_ACK,
}
_FAULTS = {
    "drop": Situation.LOST,
    "delay": Situation.DELAYED,
    "reorder": Situation.REORDERED,
    "duplicate": Situation.DUPLICATED,
    "corrupt": Situation.DAMAGED,
}


def count_coverage(entries: Iterable[tuple[str, Entry]], plan: Plan) -> dict[str, int]:
    """How often each situation occurred in a run, without those that did not occur."""
    history = _History(plan)
    for source, entry in sorted(entries, key=lambda each: each[1].t_s):
        history.hear(source, entry.t_s, entry.record)
    return {name.value: count for name, count in history.counts.items()}


def uncovered(counts: Mapping[str, int]) -> list[str]:
    """The situations that did not occur at all."""
    return [each.value for each in Situation if not counts.get(each.value)]


class _History:
    """The state of the run, as far as the timeline has been read."""

    def __init__(self, plan: Plan) -> None:
        self.counts: Counter[Situation] = Counter()
        self._adversary = Adversary(plan, self._count)
        self._views = Views(self._count)
        self._points = {
            rule.name: rule.point for rule in plan.rules if isinstance(rule, ProcessRule) and rule.point
        }
        self._bursts = {rule.name for rule in plan.rules if isinstance(rule, MessageRule) and rule.burst}
        self._known: set[int] = set()
        """The robots that have been in a view."""
        self._turns = False
        """Whether the strand turns round, backs up or dissolves: until the leader's next step."""
        self._down: set[int] = set()
        self._dead: set[int] = set()
        self._restarted: set[int] = set()
        self._thawed_s: dict[int, float] = {}
        self._killed: tuple[float, tuple[int, ...]] = (-1.0, ())

    def hear(self, source: str, t_s: float, record: Record) -> None:
        """Read the next entry."""
        self._adversary.hear(source, t_s, record)
        self._views.hear(source, t_s, record)
        robot = robot_number(source)
        if source == WORLD:
            self._hear_world(t_s, record)
        elif robot is not None:
            self._hear_robot(robot, record)
        if isinstance(record, FaultInjected) and record.process is None:
            self._hear_message_fault(record)

    def _count(self, situation: Situation) -> None:
        self.counts[situation] += 1

    # --- the world's entries ------------------------------------------------------------------------

    def _hear_world(self, t_s: float, record: Record) -> None:
        match record:
            case FaultInjected(fault=fault, process=str(process), rule=rule):
                self._hear_process_fault(t_s, fault, process, rule)
            case OrderRefused():
                self._refuse(t_s, record)
            case RobotDied(robot=robot):
                self._dead.add(robot)
            case RobotReturned(robot=robot):
                self._dead.discard(robot)
            case RobotRestarted(robot=robot):
                self._dead.discard(robot)
                self._restarted.add(robot)
            case _:
                pass

    def _refuse(self, t_s: float, refused: OrderRefused) -> None:
        """Count an order that came too late; and a zombie, whose order comes just after its thaw."""
        if "basis" in refused.reason:
            self._count(Situation.STALE_ORDER_REFUSED)
        elif refused.epoch < refused.fence:
            self._count(Situation.STALE_EPOCH_REFUSED)
            thawed_s = self._thawed_s.pop(refused.robot, None)
            if thawed_s is not None and t_s - thawed_s <= WAKES_S:
                self._count(Situation.ZOMBIE_SPOKE)
        elif refused.turn < refused.fence_turn:
            self._count(Situation.STALE_TURN_REFUSED)

    def _hear_process_fault(self, t_s: float, fault: str, process: str, rule: str) -> None:
        robot = robot_number(process)
        if robot is None:
            return
        match fault:
            case "kill":
                self._kill(t_s, robot, rule)
            case "freeze":
                self._down.add(robot)
            case "thaw":
                self._down.discard(robot)
                self._thawed_s[robot] = t_s
            case "start":
                self._down.discard(robot)
            case _:
                pass

    def _kill(self, t_s: float, robot: int, rule: str) -> None:
        self._down.add(robot)
        if (point := self._points.get(rule)) is not None:
            self._count(_POINTS[point])
        order = self._views.order
        if order and robot == order[0]:
            self._count(Situation.LEADER_KILLED)
        if order and robot == order[-1]:
            self._count(Situation.TAIL_KILLED)
        if self._turns:
            self._count(Situation.KILLED_IN_REVERSAL)
        killed_s, killed = self._killed
        if killed_s == t_s and any(self._are_neighbours(robot, other) for other in killed):
            self._count(Situation.TWO_NEIGHBOURS_KILLED)
        self._killed = (t_s, (*killed, robot) if killed_s == t_s else (robot,))

    def _are_neighbours(self, one: int, other: int) -> bool:
        order = self._views.order
        return one in order and other in order and abs(order.index(one) - order.index(other)) == 1

    # --- the robots' entries ------------------------------------------------------------------------

    def _hear_robot(self, robot: int, record: Record) -> None:
        match record:
            case ViewJoined():
                self._known.add(robot)
                self._thawed_s.pop(robot, None)
            case StrandJoined() if robot in self._restarted:
                self._restarted.discard(robot)
                self._count(Situation.RESTART_JOINED)
            case StrandHealed():
                if self._known - set(self._views.order) - self._dead - self._down:
                    self._count(Situation.SPLIT_HELD)
            case LinkBroken(neighbour=neighbour, cause="token") if neighbour not in self._down:
                self._count(Situation.FALSE_TOKEN_LOSS)
            case StrandReversed() | StrandDissolved():
                self._turns = True
            case StrandFormed(back_by_m=back_by_m) if back_by_m > 0.0:
                self._turns = True
            case StepPlanned(joins=False):
                self._turns = False
            case _:
                pass

    # --- messages -----------------------------------------------------------------------------------

    def _hear_message_fault(self, record: FaultInjected) -> None:
        if (situation := _FAULTS.get(record.fault)) is not None:
            self._count(situation)
        if record.rule in self._bursts:
            self._count(Situation.LOST_IN_BURST)
