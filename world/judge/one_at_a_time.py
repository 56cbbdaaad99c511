"""S3 while robots line up: one robot moves at a time, by the orders of one call.

Rule 1: while robots line up, a body drives to the target of a step in its robot's turn, and no other moves.
Rule 2: no two robots move at the same time by the orders of different calls.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from protocol.epochs import of_one_call

from protocol.timeline import PromiseBroken
from world.judge.evidence import ROUNDING_M, ROUNDING_S, Evidence


@dataclass(frozen=True, slots=True)
class _Drive:
    """A motion between two samples."""

    start_s: float
    end_s: float
    robot: int
    joins: bool
    moved_m: float
    epoch: int


def judge_one_at_a_time(evidence: Evidence) -> Iterator[tuple[float, PromiseBroken]]:
    """Every violation with its time, once per pair of robots and rule."""
    epochs = {order.epoch for each in evidence.orders.values() for _, order in each}
    lined_up = not evidence.lining_up.isdisjoint(epochs)
    called = bool(epochs) and not of_one_call(min(epochs), max(epochs))
    if not lined_up and not called:
        return
    drives = [drive for robot in evidence.poses for drive in _drives(evidence, robot)]
    drives.sort(key=lambda drive: drive.start_s)
    yield from _judge_joining(drives)
    yield from _judge_calls(drives)


def _judge_joining(drives: Sequence[_Drive]) -> Iterator[tuple[float, PromiseBroken]]:
    """Robots that moved while another joined, once per pair."""
    longest = longest_joining = _Drive(-math.inf, -math.inf, 0, False, 0.0, 0)
    accused: set[tuple[int, int]] = set()
    for drive in drives:
        other = longest if drive.joins else longest_joining
        two = (drive.robot, other.robot)
        if other.end_s > drive.start_s + ROUNDING_S and two not in accused:
            accused.add(two)
            why = f"moved while robot {other.robot} did, before the strand had formed"
            yield drive.start_s, _breach(drive, why)
        longest = max(longest, drive, key=lambda each: each.end_s)
        if drive.joins:
            longest_joining = max(longest_joining, drive, key=lambda each: each.end_s)


def _judge_calls(drives: Sequence[_Drive]) -> Iterator[tuple[float, PromiseBroken]]:
    """Robots that moved while another moved by the orders of another call, once per pair."""
    newest: dict[int, _Drive] = {}  # by call: the motion that ends last
    accused: set[tuple[int, int]] = set()
    for drive in drives:
        for call, other in newest.items():
            two = (drive.robot, other.robot)
            if of_one_call(call, drive.epoch) or other.end_s <= drive.start_s + ROUNDING_S or two in accused:
                continue
            accused.add(two)
            why = f"moved while robot {other.robot} did, by the orders of another call"
            yield drive.start_s, _breach(drive, why)
        same = next((call for call in newest if of_one_call(call, drive.epoch)), drive.epoch)
        newest[same] = max(newest.get(same, drive), drive, key=lambda each: each.end_s)


def _drives(evidence: Evidence, robot: int) -> Iterator[_Drive]:
    """All motions of a body that have a length."""
    orders = evidence.orders[robot]
    lining_up = evidence.lining_up
    taken_s = [t_s for t_s, _ in orders]
    for (start_s, start), (end_s, end) in pairwise(evidence.poses[robot]):
        moved_m = math.hypot(end.x_m - start.x_m, end.y_m - start.y_m)
        if moved_m > ROUNDING_M:
            in_hand = bisect_right(taken_s, start_s + ROUNDING_S) - 1
            joins = in_hand >= 0 and orders[in_hand][1].epoch in lining_up
            epoch = orders[in_hand][1].epoch if in_hand >= 0 else 0
            yield _Drive(start_s, end_s, robot, joins, moved_m, epoch)


def _breach(drive: _Drive, why: str) -> PromiseBroken:
    return PromiseBroken(invariant="S3", robot=drive.robot, measured_m=drive.moved_m, required_m=0.0, why=why)
