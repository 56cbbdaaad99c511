"""What bodies are ordered to do: F1, F2 and F6 as orders show them, S3 while robots join, F5 under ALL.

An order to stand is always lawful. Of the others:

Rule 1 (F1): a body accepts an order only if it bears exactly the fence in force, and the fence names its
        robot: as the one that may move, in that life, or with all.
Rule 2 (F2): no order bears a fence that is not in force yet.
Rule 3 (F6): the body has been scanned under that very fence. Followers do not sense under a law that promises
        no clearance.
Rule 4 (S3): a robot that joins orders its body only to the target of a step that it had planned in the epoch.
Rule 5 (F4): under ALL, an order is of the life that the formation names, and its robot stood at its place in
        the formation, within mu0, when ALL came into force.
Rule 6 (F5): under ALL, only members order motion. The leader goes to targets of steps that it had planned, or
        along the path that the formation laid; any other member goes along the strand's path, and only as far
        as the robot ahead had granted by then in that epoch. A granter's clock is never ahead of the world's,
        so a grant with a later time than the order came too late, whenever it was recorded.
Rule 7: a robot that was killed may not have recorded its last grants, steps and formation. So rules 4 to 6
        excuse an order between that robot's last entry and its death.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator
from operator import itemgetter

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import OrderAccepted, PromiseBroken
from world.judge.evidence import JOINS, ROUNDING_M, Evidence, Formed, Taken, apart_m
from world.judge.fences import ROUNDING_S
from world.judge.motion import Tolerance, breach_of
from world.judge.paths import Paths

Dated = tuple[float, PromiseBroken]


class Authority:
    """Judges the orders of one run."""

    def __init__(self, evidence: Evidence, tolerance: Tolerance, *, followers_sense: bool) -> None:
        self._evidence = evidence
        self._tolerance = tolerance
        self._followers_sense = followers_sense
        self._paths = Paths(evidence)

    def judge(self) -> Iterator[Dated]:
        """Every violation with its time; each order counts at most once for each invariant."""
        for _, orders in sorted(self._evidence.orders.items()):
            placed: set[int] = set()  # epochs in which the robot's place has been compared
            for taken in orders:
                if taken.order.target is None:
                    continue
                unborne = self._unborne(taken)
                if unborne is not None:
                    yield taken.t_s, unborne
                    continue
                yield from ((taken.t_s, breach) for breach in self._borne(taken, taken.order.target))
                epoch = taken.order.epoch
                if self._evidence.fences[taken.fence].may is May.ALL and epoch not in placed:
                    placed.add(epoch)
                    yield from ((taken.t_s, breach) for breach in self._displaced(taken))

    def _unborne(self, taken: Taken) -> PromiseBroken | None:
        """Rules 1 and 2."""
        order, fence = taken.order, self._evidence.fences[taken.fence]
        bears, now = (order.epoch, order.turn), (fence.epoch, fence.turn)
        if bears != now:
            told = f"turn {order.turn} of epoch {order.epoch}"
            why = f"its body takes an order of {told} in turn {now[1]} of epoch {now[0]}"
            return _breach("F2" if bears > now else "F1", order, why)
        if fence.may is May.ALL or (fence.named, fence.named_life) == (order.robot, order.life):
            return None
        who = f"robot {fence.named} in life {fence.named_life}" if fence.may is May.ONE else "nobody"
        return _breach("F1", order, f"its body takes an order of life {order.life} where {who} may move")

    def _borne(self, taken: Taken, target: Point) -> Iterator[PromiseBroken]:
        """Rules 3 to 6 for an order that bears its fence."""
        order, fences = taken.order, self._evidence.fences
        joins = fences[taken.fence].may is May.ONE
        if not self._is_seen(taken):
            why = f"ordered in turn {order.turn} of epoch {order.epoch}, in which its body was not scanned"
            yield _breach("F6", order, why)
        if joins:
            yield from self._elsewhere("S3", taken, target, JOINS)
            return
        formed = self._evidence.formed.get(order.epoch)
        if formed is None:
            return  # F4 asks for the formation
        rank, lives = formed.ranks.get(order.robot), formed.strand.lives
        if rank is not None and rank < len(lives) and lives[rank] != order.life:
            why = f"ordered in life {order.life}, where the formation names {lives[rank]}"
            yield _breach("F4", order, why)
        elif rank is None:
            yield _breach("F5", order, "ordered in a strand of which it is no member")
        elif rank == 0 and order.step > 0:
            yield from self._elsewhere("F5", taken, target, order.step)
        else:
            yield from self._along(taken, target, formed, rank)

    def _is_seen(self, taken: Taken) -> bool:
        """Rule 3."""
        fence = self._evidence.fences[taken.fence]
        if fence.may is May.ALL and taken.order.step == 0 and not self._followers_sense:
            return True
        return taken.scanned == taken.fence

    def _elsewhere(self, invariant: str, taken: Taken, target: Point, step: int) -> Iterator[PromiseBroken]:
        """Rule 4, and rule 6 for a step of the leader."""
        order = taken.order
        plans = self._evidence.plans.get((order.robot, order.epoch), {}).get(step, ())
        by_then = [plan for at_s, plan in plans if at_s <= taken.t_s + ROUNDING_S]
        miss_m = min((apart_m(target, plan.target) for plan in by_then), default=math.inf)
        if miss_m <= ROUNDING_M or self._evidence.may_have_said_more(order.robot, taken.t_s):
            return
        what = "a step to join" if step == JOINS else f"step {step}"
        if by_then:
            yield breach_of(invariant, order.robot, miss_m, 0.0, f"ordered elsewhere than {what} was planned")
        else:
            yield _breach(invariant, order, f"ordered {what} that was not planned")

    def _along(self, taken: Taken, target: Point, formed: Formed, rank: int) -> Iterator[PromiseBroken]:
        """Rule 6 along the path: as far as the robot ahead granted, or as the formation laid it."""
        order, strand, path = taken.order, formed.strand, self._paths.of(formed.strand)
        if path is None:
            yield _breach("F5", order, f"ordered in epoch {order.epoch}, whose strand has no path")
            return
        if rank == 0:
            granter, granted_m, ahead = "the formation laid", path[len(strand.laid) - 1].s_m, order.robot
        else:
            ahead = strand.order[rank - 1]
            granter, granted_m = f"robot {ahead} granted", self._granted_m(taken, ahead)
        allowed_m = self._tolerance.mu0_m + self._tolerance.drive_m(
            math.hypot(target.x_m - order.x_m, target.y_m - order.y_m)
        )
        beside_m = apart_m(target, path.at(order.reach_m))
        if order.reach_m > granted_m + ROUNDING_M and not self._excused(taken, ahead):
            why = f"ordered further than {granter}"
            yield breach_of("F5", order.robot, order.reach_m, granted_m, why)
        elif beside_m > allowed_m and not self._excused(taken, ahead, strand.order[0]):
            why = "ordered beside the strand's path"
            yield breach_of("F5", order.robot, beside_m, allowed_m, why)

    def _granted_m(self, taken: Taken, ahead: int) -> float:
        grants = self._evidence.granted.get((ahead, taken.order.robot, taken.order.epoch), ())
        by_then = bisect_right(grants, taken.t_s + ROUNDING_S, key=itemgetter(0))
        return grants[by_then - 1][1] if by_then else 0.0

    def _excused(self, taken: Taken, *robots: int) -> bool:
        """Rule 7."""
        return any(self._evidence.may_have_said_more(robot, taken.t_s) for robot in robots)

    def _displaced(self, taken: Taken) -> Iterator[PromiseBroken]:
        """Rule 5, for the first order of a robot under ALL."""
        order, evidence = taken.order, self._evidence
        formed = evidence.formed.get(order.epoch)
        rank = None if formed is None else formed.ranks.get(order.robot)
        if formed is None or rank is None:
            return
        strand, path = formed.strand, self._paths.of(formed.strand)
        stood = evidence.place_at(order.robot, evidence.fences.times_s[taken.fence])
        if path is None or rank >= len(strand.places_m) or stood is None:
            return
        off_m, allowed_m = apart_m(stood, path.at(strand.places_m[rank])), self._tolerance.mu0_m + ROUNDING_M
        if off_m > allowed_m:
            why = "ordered in a strand, but did not stand at its place when the strand was to drive"
            yield breach_of("F4", order.robot, off_m, allowed_m, why)


def _breach(invariant: str, order: OrderAccepted, why: str) -> PromiseBroken:
    return PromiseBroken(invariant=invariant, robot=order.robot, why=why)
