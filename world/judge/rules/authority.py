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
from collections.abc import Iterator
from dataclasses import dataclass

from protocol.fence import NUMBERS, May
from protocol.frames import Point
from protocol.keys import WORLD, robot_name
from protocol.timeline import Entry, OrderAccepted, PromiseBroken
from world.judge.rules.claims import ROUNDING_S, Check, Claim, Claims
from world.judge.rules.evidence import ROUNDING_M, Evidence, Formed, apart_m
from world.judge.rules.motion import Tolerance
from world.judge.rules.paths import JOINS
from world.judge.rules.rule import Dated, breach_of, broken

Found = list[PromiseBroken] | frozenset[str]
"""Violations, or the sources that may still show that there is none."""


class Authority:
    """Judges the orders of one run."""

    kinds = frozenset[type]({OrderAccepted})

    def __init__(
        self, evidence: Evidence, claims: Claims, tolerance: Tolerance, *, followers_sense: bool
    ) -> None:
        self._evidence = evidence
        self._claims = claims
        self._tolerance = tolerance
        self._followers_sense = followers_sense
        self._placed: dict[int, int] = {}
        """The newest epoch in which the place of each robot has been compared."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Judge an order; it counts at most once for each invariant."""
        order = entry.record
        if source != WORLD or not isinstance(order, OrderAccepted) or order.target is None:
            return
        unborne = self._unborne(order)
        if unborne is not None:
            yield entry.t_s, unborne
            return
        if not self._is_seen(order):
            why = f"ordered in turn {order.turn} of epoch {order.epoch}, in which its body was not scanned"
            yield entry.t_s, broken("F6", order.robot, why)
        if self._evidence.fences.now.may is May.ONE:
            yield from self._claims.judge(entry.t_s, order.epoch, self._as_planned("S3", order, JOINS))
            return
        yield from self._claims.judge(
            entry.t_s, order.epoch, _InStrand(order, self._evidence, self._tolerance)
        )
        if self._placed.get(order.robot) != order.epoch:
            self._placed[order.robot] = order.epoch
            yield from self._claims.judge(entry.t_s, order.epoch, self._in_place(order))
        self._evidence.grants.advance(order.epoch, min(entry.t_s, self._claims.oldest_s(order.epoch)))

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    def _unborne(self, order: OrderAccepted) -> PromiseBroken | None:
        """Rules 1 and 2."""
        fence = self._evidence.fences.now
        bears, now = (order.epoch, order.turn), (fence.epoch, fence.turn)
        if bears != now:
            told = f"turn {order.turn} of epoch {order.epoch}"
            why = f"its body takes an order of {told} in turn {now[1]} of epoch {now[0]}"
            return broken("F2" if bears > now else "F1", order.robot, why)
        if fence.may is May.ALL or (fence.named, fence.named_life) == (order.robot, order.life):
            return None
        who = f"robot {fence.named} in life {fence.named_life}" if fence.may is May.ONE else "nobody"
        return broken("F1", order.robot, f"its body takes an order of life {order.life} where {who} may move")

    def _is_seen(self, order: OrderAccepted) -> bool:
        """Rule 3."""
        fences = self._evidence.fences
        if fences.now.may is May.ALL and order.step == 0 and not self._followers_sense:
            return True
        return self._evidence.scanned.get(order.robot) == fences.newest

    def _as_planned(self, invariant: str, order: OrderAccepted, step: int) -> Check:
        def check(claim: Claim) -> Found:
            return _as_planned(self._evidence, invariant, order, step, claim)

        return check

    def _in_place(self, order: OrderAccepted) -> Check:
        """Rule 5, for the first order of a robot under ALL."""
        place: Point | None = None

        def check(claim: Claim) -> Found:
            nonlocal place
            place = place or self._evidence.standing.at(order.robot, order.epoch)
            if place is None and claim.may_hear(WORLD):
                return frozenset({WORLD})
            if place is None:  # not sampled since: it has not moved
                place = Point(x_m=order.x_m, y_m=order.y_m)
            formed = self._evidence.formed.get(order.epoch)
            if formed is None:
                return claim.awaiting(robot_name(order.epoch % NUMBERS))
            rank = formed.ranks.get(order.robot)
            if rank is None:
                return []
            strand, path = formed.strand, self._evidence.paths.of(formed.strand)
            if path is None or rank >= len(strand.places_m):
                return []
            off_m = apart_m(place, path.at(strand.places_m[rank]))
            allowed_m = self._tolerance.mu0_m + ROUNDING_M
            why = "ordered in a strand, but did not stand at its place when the strand was to drive"
            breach = breach_of("F4", order.robot, off_m, allowed_m, why)
            return [breach] if off_m > allowed_m else []

        return check


def _as_planned(evidence: Evidence, invariant: str, order: OrderAccepted, step: int, claim: Claim) -> Found:
    """Rule 4, and rule 6 for a step of the leader."""
    robot = order.robot
    target = order.target
    assert target is not None, "an order to stand is always lawful"
    plans = evidence.paths.plans(robot, order.epoch, step)
    by_then = [planned for at_s, planned in plans if at_s <= claim.t_s + ROUNDING_S]
    miss_m = min((apart_m(target, planned) for planned in by_then), default=math.inf)
    if miss_m <= ROUNDING_M:
        return []
    if claim.may_hear(robot_name(robot)):
        return frozenset({robot_name(robot)})
    if evidence.may_have_said_more(robot, claim.t_s, claim.heard_after_s(robot_name(robot))):
        return []
    what = "a step to join" if step == JOINS else f"step {step}"
    if by_then:
        return [breach_of(invariant, robot, miss_m, 0.0, f"ordered elsewhere than {what} was planned")]
    return [broken(invariant, robot, f"ordered {what} that was not planned")]


@dataclass(frozen=True, slots=True)
class _InStrand:
    """Rules 5 to 7 for one order under ALL."""

    order: OrderAccepted
    evidence: Evidence
    tolerance: Tolerance

    def __call__(self, claim: Claim) -> Found:
        """Check the order."""
        order, formed = self.order, self.evidence.formed.get(self.order.epoch)
        if formed is None:  # F4 asks for the formation
            return claim.awaiting(robot_name(order.epoch % NUMBERS))
        rank, lives = formed.ranks.get(order.robot), formed.strand.lives
        if rank is not None and rank < len(lives) and lives[rank] != order.life:
            why = f"ordered in life {order.life}, where the formation names {lives[rank]}"
            return [broken("F4", order.robot, why)]
        if rank is None:
            return [broken("F5", order.robot, "ordered in a strand of which it is no member")]
        if rank == 0 and order.step > 0:
            return _as_planned(self.evidence, "F5", order, order.step, claim)
        return self._along(claim, formed, rank)

    def _along(self, claim: Claim, formed: Formed, rank: int) -> Found:
        """Rule 6 along the path: as far as the robot ahead granted, or as the formation laid it."""
        order, strand = self.order, formed.strand
        path = self.evidence.paths.of(strand)
        if path is None:
            why = f"ordered in epoch {order.epoch}, whose strand has no path"
            return [broken("F5", order.robot, why)]
        if rank == 0:
            granter, ahead = "the formation laid", order.robot
            granted_m = path[len(strand.laid) - 1].s_m
        else:
            ahead = strand.order[rank - 1]
            granter = f"robot {ahead} granted"
            granted_m = self.evidence.grants.by((ahead, order.robot, order.epoch), claim.t_s)
        if order.reach_m > granted_m + ROUNDING_M:
            if rank > 0 and claim.may_hear(robot_name(ahead)):
                return frozenset({robot_name(ahead)})
            if self._is_excused(claim, ahead):
                return []
            why = f"ordered further than {granter}"
            return [breach_of("F5", order.robot, order.reach_m, granted_m, why)]
        return self._beside(claim, formed)

    def _beside(self, claim: Claim, formed: Formed) -> Found:
        """Rule 6: the target is on the path, once the path is certain that far."""
        order, strand = self.order, formed.strand
        leader, target = strand.order[0], order.target
        path = self.evidence.paths.of(strand)
        assert path is not None, "checked before"
        assert target is not None, "checked before"
        is_certain = order.reach_m <= self.evidence.paths.certain_m(strand) + ROUNDING_M
        if not is_certain and claim.may_hear(robot_name(leader)):
            return frozenset({robot_name(leader)})
        length_m = math.hypot(target.x_m - order.x_m, target.y_m - order.y_m)
        allowed_m = self.tolerance.mu0_m + self.tolerance.drive_m(length_m)
        beside_m = apart_m(target, path.at(order.reach_m))
        if beside_m <= allowed_m:
            return []
        if claim.may_hear(robot_name(leader)):
            return frozenset({robot_name(leader)})
        ahead = strand.order[max(formed.ranks[order.robot] - 1, 0)]
        if self._is_excused(claim, ahead, leader):
            return []
        return [breach_of("F5", order.robot, beside_m, allowed_m, "ordered beside the strand's path")]

    def _is_excused(self, claim: Claim, *robots: int) -> bool:
        """Rule 7."""
        return any(
            self.evidence.may_have_said_more(robot, claim.t_s, claim.heard_after_s(robot_name(robot)))
            for robot in robots
        )
