"""P1 to P6: the invariants of every run besides S1 to S3, under any loss, delay, damage, kill or freeze.

They are judged from the timeline alone, in one place for live runs, rehearsals and logs.
P1: the strand of an epoch has one order. Only its first robot leads it: only that robot plans steps and
    records that it leads.
P2: epochs never decrease, neither in the entries of one process of a robot, nor in the orders of a body.
P3: there is no ring, and each robot has one robot ahead: an order names a robot once, and ground is granted
    only to the robot directly behind in the order of that epoch.
P4: stale or forged messages have no effect. No body accepts an order to move, or continues one, from an epoch
    before the muster that its robot has joined. No robot joins a muster without being called, or is in the
    muster's strand with a robot that was not called.
P5: queues are bounded and long enough: no inbox or outbox overflows, and entry numbers have no gaps.
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
"""All invariants of a run, in the order of the verdict."""

Dated = tuple[float, PromiseBroken]


def judge_invariants(evidence: Evidence, mission: Mission) -> list[Dated]:
    """Every violation of P1 to P6 with its time; identical violations count once."""
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
    """P2 for entries: each new strand and muster has a newer epoch, and nothing has an older one."""
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
                pass  # has no epoch


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
                pass  # no violation


def _judge_orders(
    robot: int,
    orders: Sequence[tuple[float, OrderAccepted]],
    joined: Sequence[tuple[float, int]],
    deadman_s: float,
) -> Iterator[Dated]:
    """P2 and P4 for the orders that a body accepts; orders to stand are always lawful.

    An order from before the robot joined may arrive as late as `deadman_s`.
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
    """P4 for motion: when its order's epoch is over, a body stands after the lease has expired."""
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
