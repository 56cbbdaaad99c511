"""The classes of faults that a swarm mixes. Pure.

Rule 1: each class has its own stream of draws, so that adding or removing a class does not change the others.
Rule 2: if the window closes, all faults of a class end before that, except that killed robots stay dead.
"""

from collections.abc import Callable
from enum import StrEnum

from clew.swarm import adversary, messages, processes
from clew.swarm.draws import Draws
from clew.swarm.window import Window
from protocol.faults.rules import Rule


class FaultClass(StrEnum):
    """A class of faults that can be in the mix."""

    LOSS = "loss"
    DELAY = "delay"
    DUPLICATION = "duplication"
    REORDERING = "reordering"
    CORRUPTION = "corruption"
    BURSTS = "bursts"
    BODY_LINK = "body_link"
    FENCE_LINK = "fence_link"
    CUT_PAIR = "cut_pair"
    CUT_ROBOT = "cut_robot"
    CUT_ONE_WAY = "cut_one_way"
    CUT_FLAPPING = "cut_flapping"
    CUT_ROUTER = "cut_router"
    KILL = "kill"
    KILL_TWO = "kill_two"
    KILL_LEADER = "kill_leader"
    KILL_TAIL = "kill_tail"
    KILL_AT_POINT = "kill_at_point"
    LOSE_COORDINATOR = "lose_coordinator"
    FREEZE = "freeze"
    RESTART = "restart"
    SLOW = "slow"
    OUTAGE = "outage"
    WORLD = "world"
    LATE = "late"
    TORN = "torn"
    STALE_CLOCK = "stale_clock"
    FORMER_ORDERS = "former_orders"
    HIDDEN_BODY = "hidden_body"
    UNSEEN_DEATH = "unseen_death"
    BLIND_START = "blind_start"
    LATE_LEASE = "late_lease"


ADVERSARY = (
    FaultClass.TORN,
    FaultClass.STALE_CLOCK,
    FaultClass.FORMER_ORDERS,
    FaultClass.HIDDEN_BODY,
    FaultClass.UNSEEN_DEATH,
    FaultClass.BLIND_START,
    FaultClass.LATE_LEASE,
)
"""Classes whose faults lie around one moment."""
INDEPENDENT = tuple(each for each in FaultClass if each not in ADVERSARY)
"""Classes whose faults are independent of each other."""


def draw_rules(fault: FaultClass, draws: Draws, window: Window) -> list[Rule]:
    """The rules of a class, from its own stream of draws."""
    return _DRAWS[fault](draws, window)


_DRAWS: dict[FaultClass, Callable[[Draws, Window], list[Rule]]] = {
    FaultClass.LOSS: messages.loss,
    FaultClass.DELAY: messages.delay,
    FaultClass.DUPLICATION: messages.duplication,
    FaultClass.REORDERING: messages.reordering,
    FaultClass.CORRUPTION: messages.corruption,
    FaultClass.BURSTS: messages.bursts,
    FaultClass.BODY_LINK: messages.body_link,
    FaultClass.FENCE_LINK: messages.fence_link,
    FaultClass.CUT_PAIR: messages.cut_pair,
    FaultClass.CUT_ROBOT: messages.cut_robot,
    FaultClass.CUT_ONE_WAY: messages.cut_one_way,
    FaultClass.CUT_FLAPPING: messages.cut_flapping,
    FaultClass.CUT_ROUTER: messages.cut_router,
    FaultClass.KILL: processes.kill,
    FaultClass.KILL_TWO: processes.kill_two,
    FaultClass.KILL_LEADER: processes.kill_leader,
    FaultClass.KILL_TAIL: processes.kill_tail,
    FaultClass.KILL_AT_POINT: processes.kill_at_point,
    FaultClass.LOSE_COORDINATOR: processes.lose_coordinator,
    FaultClass.FREEZE: processes.freeze,
    FaultClass.RESTART: processes.restart,
    FaultClass.SLOW: processes.slow,
    FaultClass.OUTAGE: processes.outage,
    FaultClass.WORLD: processes.world,
    FaultClass.LATE: messages.late,
    FaultClass.TORN: adversary.torn,
    FaultClass.STALE_CLOCK: adversary.stale_clock,
    FaultClass.FORMER_ORDERS: adversary.former_orders,
    FaultClass.HIDDEN_BODY: adversary.hidden_body,
    FaultClass.UNSEEN_DEATH: adversary.unseen_death,
    FaultClass.BLIND_START: adversary.blind_start,
    FaultClass.LATE_LEASE: adversary.late_lease,
}
