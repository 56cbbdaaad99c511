"""P1 to P6: what holds of every run beside S1 to S3, whatever is lost, late, damaged, killed or frozen.

From the timeline alone, and in one place: runs are judged by it live and rehearsed, and so are logs.
P1: the strand of an epoch has one order, and its first robot alone leads it: plans steps, says that it leads.
P2: epochs never go back: neither in what one process of a robot says, nor in the orders that a body takes.
P3: no ring, and one robot ahead of each: an order names a robot once, and nobody is granted ground but the
    robot right behind in the order of that epoch.
P4: nothing stale or forged is applied: no body takes an order to move of an epoch before the muster that its
    robot has joined, or moves on with one; no robot joins a muster to which it was not called, or is in a
    strand of one with somebody who was not.
P5: queues are bounded and long enough: no inbox and no outbox overflows; a process counts its entries by one.
P6: no core fails.
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise
from operator import itemgetter

from protocol.mission import Mission
from protocol.timeline import (
    AuthorityGranted,
    MusterJoined,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    RobotFailed,
    RobotStarted,
    StepPlanned,
    StrandFormed,
    TrafficCounted,
)
from world.judge.evidence import ROUNDING_M, ROUNDING_S, Evidence
from world.judge.history import Told
from world.judge.strand_law import broken, judge_told

INVARIANTS = ("S1", "S2", "S3", "P1", "P2", "P3", "P4", "P5", "P6")
"""All that a run is judged by, in the order in which they are counted."""

Dated = tuple[float, PromiseBroken]


def judge_invariants(evidence: Evidence, mission: Mission) -> list[Dated]:
    """Every breach of P1 to P6 with its time; what breaks again in the same way is one."""
    history = evidence.history
    breaches = [
        (t_s, broken("P5", robot, f"its entries go on with number {n}")) for t_s, robot, n in history.holes
    ]
    for robot in sorted(history.told):
        breaches += judge_told(history, robot)
        breaches += _judge_epochs(robot, history.told[robot])
        breaches += _judge_process(robot, history.told[robot])
    for robot, orders in sorted(evidence.orders.items()):
        joined = history.joined(robot)
        breaches += _judge_orders(robot, orders, joined, mission.deadman_s)
        grace_s = mission.silence_s + mission.deadman_s
        breaches += _judge_motion(evidence.poses[robot], orders, joined, grace_s)
    first: dict[PromiseBroken, float] = {}
    for t_s, breach in sorted(breaches, key=itemgetter(0)):
        first.setdefault(breach, t_s)
    return [(t_s, breach) for breach, t_s in first.items()]


def _judge_epochs(robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """P2, in what processes say: each new strand and muster is of a newer epoch, nothing of an older one."""
    newest = -1
    for t_s, record in told:
        match record:
            case RobotStarted():
                newest = -1
            case StrandFormed(epoch=epoch) | MusterJoined(epoch=epoch):
                if epoch <= newest:
                    yield t_s, broken("P2", robot, f"goes from epoch {newest} to {epoch}")
                newest = max(newest, epoch)
            case StepPlanned(epoch=epoch) | AuthorityGranted(epoch=epoch):
                if epoch < newest:
                    yield t_s, broken("P2", robot, f"plans or grants in epoch {epoch}, after {newest}")
            case _:
                pass  # says of no epoch that it is in it


def _judge_process(robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """P5 and P6."""
    for t_s, record in told:
        match record:
            case TrafficCounted(overflowed=overflowed, unrecorded=unrecorded) if overflowed or unrecorded:
                why = f"dropped {overflowed} arrivals and {unrecorded} entries: its queues were full"
                yield t_s, broken("P5", robot, why)
            case RobotFailed(reason=reason):
                yield t_s, broken("P6", robot, reason)
            case _:
                pass  # all is well


def _judge_orders(
    robot: int,
    orders: Sequence[tuple[float, OrderAccepted]],
    joined: Sequence[tuple[float, int]],
    deadman_s: float,
) -> Iterator[Dated]:
    """P2 and P4, in the orders that a body takes; to stand still is always lawful.

    What a robot ordered before it joined may come as late as it is good for.
    """
    newest = 0
    for t_s, order in orders:
        if order.target is None:
            continue
        if order.epoch < newest:
            yield t_s, broken("P2", robot, f"its body takes an order of epoch {order.epoch} after {newest}")
        newest = max(newest, order.epoch)
        bound = max((epoch for at_s, epoch in joined if at_s + deadman_s + ROUNDING_S < t_s), default=0)
        if order.epoch < bound:
            why = f"its body takes an order of epoch {order.epoch} when it has joined muster {bound}"
            yield t_s, broken("P4", robot, why)


def _judge_motion(
    poses: Sequence[tuple[float, PoseSampled]],
    orders: Sequence[tuple[float, OrderAccepted]],
    joined: Sequence[tuple[float, int]],
    grace_s: float,
) -> Iterator[Dated]:
    """P4, in what a body does: it stands when its order's epoch is over, once the lease has run out."""
    if not joined:
        return
    taken_s = [t_s for t_s, _ in orders]
    for (start_s, start), (end_s, end) in pairwise(poses):
        if abs(end.x_m - start.x_m) <= ROUNDING_M and abs(end.y_m - start.y_m) <= ROUNDING_M:
            continue
        in_hand = bisect_right(taken_s, start_s + ROUNDING_S) - 1
        bound = max((epoch for at_s, epoch in joined if at_s + grace_s + ROUNDING_S < start_s), default=0)
        if in_hand >= 0 and orders[in_hand][1].epoch < bound:
            why = f"moves in epoch {orders[in_hand][1].epoch} when it has joined muster {bound}"
            yield end_s, broken("P4", start.robot, why)
