"""What a campaign has to have seen at times, or it proves little: read in timelines. Pure.

Rule 1: a counter counts what happened, not what a plan asked for.
Rule 2: all read the timeline alone, in the order of time; so a recorded run has them as well.
"""

from collections import Counter
from collections.abc import Iterable, Mapping

from clew.campaign.coverage_adversary import Adversary
from clew.campaign.coverage_names import Sometimes
from protocol.faults.plan import Plan
from protocol.faults.rules import MessageRule, ProcessRule, StepPoint
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    LinkBroken,
    MusterCalled,
    MusterJoined,
    OrderAccepted,
    OrderRefused,
    Record,
    RobotBlocked,
    RobotDied,
    RobotPlaced,
    RobotRestarted,
    RobotReturned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    StrandReversed,
)

WAKES_S = 1.0  # what a thawed robot says so soon after, it says before it has heard what has happened


_POINTS = {
    StepPoint.AFTER_SCAN: Sometimes.KILLED_AFTER_SCAN,
    StepPoint.AFTER_PLAN: Sometimes.KILLED_AFTER_PLAN,
    StepPoint.MID_DRIVE: Sometimes.KILLED_MID_DRIVE,
    StepPoint.BEFORE_ACK: Sometimes.KILLED_BEFORE_ACK,
}
_FAULTS = {
    "drop": Sometimes.LOST,
    "delay": Sometimes.DELAYED,
    "reorder": Sometimes.REORDERED,
    "duplicate": Sometimes.DUPLICATED,
    "corrupt": Sometimes.DAMAGED,
}


def sometimes(entries: Iterable[tuple[str, Entry]], plan: Plan) -> dict[str, int]:
    """How often each has happened in a run; what never did is not there."""
    history = _History(plan)
    for source, entry in sorted(entries, key=lambda each: each[1].t_s):
        history.hear(source, entry.t_s, entry.record)
    return {name.value: count for name, count in history.counts.items()}


def never(counts: Mapping[str, int]) -> list[str]:
    """What has not happened at all."""
    return [each.value for each in Sometimes if not counts.get(each.value)]


class _History:
    """What was going on, as far as the timeline has been read."""

    def __init__(self, plan: Plan) -> None:
        self.counts: Counter[Sometimes] = Counter()
        self._adversary = Adversary(plan, self._count)
        self._points = {
            rule.name: rule.point for rule in plan.rules if isinstance(rule, ProcessRule) and rule.point
        }
        self._bursts = {rule.name for rule in plan.rules if isinstance(rule, MessageRule) and rule.burst}
        self._order: tuple[int, ...] = ()
        self._epochs: dict[int, int] = {}
        """Each robot's own, as it has said."""
        self._lining: set[int] = set()
        self._joining: set[int] = set()
        self._turns = False
        """Whether the strand turns round, backs up or dissolves: until somebody leads on, or calls."""
        self._call: tuple[int, int] | None = None
        """The newest call that has not come to a strand: its epoch and caller."""
        self._down: set[int] = set()
        self._dead: set[int] = set()
        self._restarted: set[int] = set()
        self._thawed_s: dict[int, float] = {}
        self._killed: tuple[float, tuple[int, ...]] = (-1.0, ())

    def hear(self, source: str, t_s: float, record: Record) -> None:
        """Take the next entry in."""
        self._adversary.hear(source, t_s, record)
        robot = robot_number(source)
        if source == WORLD:
            self._hear_world(t_s, record)
        elif robot is not None:
            self._hear_robot(robot, record)
        if isinstance(record, FaultInjected) and record.process is None:
            self._hear_message_fault(record)

    def _count(self, what: Sometimes) -> None:
        self.counts[what] += 1

    # --- the world's entries ------------------------------------------------------------------------

    def _hear_world(self, t_s: float, record: Record) -> None:
        match record:
            case FaultInjected(fault=fault, process=str(process), rule=rule):
                self._strike(t_s, fault, process, rule)
            case OrderRefused(robot=robot, reason=reason):
                self._count(
                    Sometimes.STALE_EPOCH_REFUSED if "epoch" in reason else Sometimes.STALE_ORDER_REFUSED
                )
                self._speak(robot, t_s)
            case OrderAccepted(robot=robot, target=target) if target is not None:
                self._speak(robot, t_s)
            case RobotDied(robot=robot):
                self._dead.add(robot)
            case RobotReturned(robot=robot):
                self._dead.discard(robot)
            case RobotRestarted(robot=robot):
                self._dead.discard(robot)
                self._restarted.add(robot)
                self._lining.add(robot)
            case _:
                pass

    def _strike(self, t_s: float, fault: str, process: str, rule: str) -> None:
        robot = robot_number(process)
        if robot is None:
            if process == "router" and fault == "kill" and self._call is not None:
                self._count(Sometimes.ROUTER_LOST_IN_MUSTER)
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
        if self._order and robot == self._order[0]:
            self._count(Sometimes.LEADER_KILLED)
            if self._call is not None and self._epochs.get(robot, 0) >= self._call[0]:
                self._count(Sometimes.LEADER_KILLED_IN_SUCCESSION)
        if self._order and robot == self._order[-1]:
            self._count(Sometimes.TAIL_KILLED)
        if self._joining:
            self._count(Sometimes.KILLED_IN_TURN)
        if self._turns:
            self._count(Sometimes.KILLED_IN_REVERSAL)
        killed_s, killed = self._killed
        if killed_s == t_s and any(self._are_neighbours(robot, other) for other in killed):
            self._count(Sometimes.TWO_NEIGHBOURS_KILLED)
        self._killed = (t_s, (*killed, robot) if killed_s == t_s else (robot,))
        self._joining.discard(robot)
        self._lining.discard(robot)

    def _are_neighbours(self, one: int, other: int) -> bool:
        order = self._order
        return one in order and other in order and abs(order.index(one) - order.index(other)) == 1

    # --- the robots' entries ------------------------------------------------------------------------

    def _hear_robot(self, robot: int, record: Record) -> None:
        match record:
            case MusterCalled(epoch=epoch):
                self._cross(robot)
                self._call = (epoch, robot)
            case MusterJoined(epoch=epoch):
                self._epochs[robot] = epoch
                self._thawed_s.pop(robot, None)
                self._lining.add(robot)
                self._joining.discard(robot)
                self._turns = False
            case StrandFormed(epoch=epoch, order=order):
                self._form(robot, epoch, order)
            case StrandHealed(members=members):
                self._call = None
                if set(self._epochs) - set(members) - self._dead - self._down:
                    self._count(Sometimes.SPLIT_HELD)
            case LinkBroken(neighbour=neighbour, cause="token") if neighbour not in self._down:
                self._count(Sometimes.FALSE_TOKEN_LOSS)
            case _:
                self._move(robot, record)

    def _move(self, robot: int, record: Record) -> None:
        """Who joins by a turn, and whether the strand turns round."""
        match record:
            case StrandReversed() | StrandDissolved():
                self._turns = True
            case StepPlanned() if robot in self._lining:
                self._joining.add(robot)
            case StepPlanned():
                self._turns = False
            case RobotPlaced() | RobotBlocked():
                self._joining.discard(robot)
            case _:
                pass

    def _form(self, robot: int, epoch: int, order: tuple[int, ...]) -> None:
        self._epochs[robot], self._order = epoch, order
        self._lining.discard(robot)
        self._joining.discard(robot)
        self._thawed_s.pop(robot, None)
        if robot in self._restarted:
            self._restarted.discard(robot)
            self._count(Sometimes.RESTART_JOINED)

    def _cross(self, caller: int) -> None:
        """A call that is made by somebody who has not come to know of the one before."""
        if self._call is not None and self._call[1] != caller and self._epochs.get(caller) != self._call[0]:
            self._count(Sometimes.CALLS_CROSSED)

    def _speak(self, robot: int, t_s: float) -> None:
        """A body has had an order. Of a robot just thawed, while others have gone on: a zombie's."""
        thawed_s = self._thawed_s.get(robot)
        newest = max(self._epochs.values(), default=0)
        if thawed_s is None or self._epochs.get(robot, 0) >= newest:
            return
        if t_s - thawed_s <= WAKES_S:
            self._count(Sometimes.ZOMBIE_SPOKE)
            del self._thawed_s[robot]

    # --- messages -----------------------------------------------------------------------------------

    def _hear_message_fault(self, record: FaultInjected) -> None:
        if record.fault == "partition" and self._lining and (record.key or "").startswith("muster/"):
            self._count(Sometimes.CUT_WHILE_LINING_UP)
        if (what := _FAULTS.get(record.fault)) is not None:
            self._count(what)
        if record.rule in self._bursts:
            self._count(Sometimes.LOST_IN_BURST)
