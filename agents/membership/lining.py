"""One robot's part in the lining up: what it announces, when it may move, and when the strand has formed.

Rule 1: it announces itself until it has its place (`agents.membership.announcer`).
Rule 2: it senses where the order depends on it (without a goal), where it looks at its leg, and in its turn.
Rule 3: the last robot in place gives the turns (`agents.membership.giving`).
Rule 4: a robot drives only in its turn, when all others have said that they know of it, and while each of
        them has echoed something that it said within `silence_s` (`agents.membership.taking`).
Rule 5: in an epoch that was called nobody drives before all members stand in it and whoever is left out must
        stand, too (docs/strand.md, Healing). Each member announces when that is, as far as it knows, and the
        latest of these times counts: a robot that is left out now may have been a member of an epoch that
        not all have heard of. A robot confirms the strand only when it knows that time, so that all know it.
"""

from collections.abc import Set

import numpy as np

from agents.body.driver import Driver
from agents.commands import Command
from agents.membership.announcer import Announcer
from agents.membership.berth import Berth
from agents.membership.giving import Giving
from agents.membership.joining import leg_is_clear, without_hulls
from agents.membership.muster import Legs
from agents.membership.taking import Taking
from agents.membership.waiting import Waiting
from agents.navigation.scan import View
from protocol.arrays import Floats
from protocol.frames import Point, Pose
from protocol.mission import Mission
from protocol.wire.messages import FIRST_ATTEMPT, Attempt, Muster


class Lining:
    """What one robot knows and says while the strand forms."""

    def __init__(
        self,
        robot: int,
        mission: Mission,
        now_s: float = 0.0,
        *,
        epoch: int = 0,
        members: tuple[int, ...] = (),
        shunned: Set[int] = frozenset(),
        berths: tuple[Berth, ...] = (),
        attempt: Attempt = FIRST_ATTEMPT,
    ) -> None:
        self.epoch = epoch
        """Of all that is said and ordered while the strand forms, whose own epoch is the next."""
        self.members = members or tuple(range(1, mission.robots + 1))
        self.settled_at_s = None if members else now_s
        """Rule 5: when all who are left out stand, as far as this robot knows; None until all are bound."""
        self.asked: int | None = None
        """The order to stand that was given when all were bound, if one was needed
        (`agents.membership.calls`)."""
        self.began_s = now_s
        self._shunned = shunned
        self._robot = robot
        self._mission = mission
        announcer = Announcer(
            robot, mission, epoch=epoch, named=members, members=self.members, attempt=attempt
        )
        self._announcer = announcer
        self._roster = announcer.roster
        self._giving = Giving(announcer, mission, arrived=bool(berths) and berths[0].arrived)
        self._taking = Taking(announcer, self._giving, mission, epoch)
        self.attempt = attempt
        self._heard_at_s: dict[int, float] = {}
        self._gaps_s: dict[int, float] = {}
        """For how long a member was not heard, at most, between two times that it was."""
        self._berths = berths
        self._leg_is_driven = False
        self._waiting = Waiting(robot, mission, self._roster, now_s)
        self._now_s = now_s

    @property
    def is_called(self) -> bool:
        """Whether its members have been named: some robots may have been left out."""
        return bool(self._announcer.said.members)

    @property
    def all_are_bound(self) -> bool:
        """Whether all members stand in this epoch."""
        return self._roster.places is not None

    @property
    def free_at_s(self) -> float | None:
        """Rule 5: when a robot that has the turn, or leads, may drive; None until that is known."""
        return self._roster.free_at_s if self.is_called else self.settled_at_s

    @property
    def places(self) -> dict[int, Pose]:
        """Where all robots stand."""
        return self._announcer.places

    @property
    def look(self) -> View | None:
        """A scan from where the robot stands, without the hulls of others; None where it has taken none."""
        return self._announcer.look

    @property
    def stuck_at_s(self) -> float | None:
        """Since when nobody who remains finds a way to a place behind this robot, the last in place."""
        return self._giving.stuck_at_s

    @property
    def others_may_come_back(self) -> bool:
        """Whether some of those that are left out may be lined up with again before long."""
        return self._giving.others_may_come_back

    @others_may_come_back.setter
    def others_may_come_back(self, may: bool) -> None:
        self._giving.others_may_come_back = may

    @property
    def finds_no_way(self) -> bool:
        """Whether this robot has had a turn in vain, or nobody who remains finds a way to behind it."""
        said = self._announcer.said
        return self.stuck_at_s is not None or (said.ended > 0 and said.rank is None)

    @property
    def wants_another_order(self) -> bool:
        """Whether this order has been tried in vain, and there are others."""
        return self._giving.wants_another_order

    @property
    def goes_on_with(self) -> tuple[int, ...]:
        """Who is in place, leader first, where these go on without the others; else empty."""
        return self._giving.goes_on_with

    @property
    def next_attempt(self) -> Attempt:
        """What is left to try when this order has been tried in vain."""
        return self._roster.next_attempt

    @property
    def legs(self) -> Legs:
        """Corners of the ways to the robots ahead, by robot."""
        return self._roster.legs

    @property
    def berths(self) -> tuple[Berth, ...]:
        """Its places in the strands that it was in last, newest first, if it has not left them."""
        return () if self._taking.has_moved else self._berths

    @property
    def leg_is_driven(self) -> bool:
        """Whether its leg is one that the robot ahead has driven, and both still stand at its ends."""
        rank = self.order.index(self._robot)
        both = [self._robot, self.order[rank - 1]]
        return self._leg_is_driven and not any(self._roster.heard[robot].ended for robot in both)

    @property
    def order(self) -> tuple[int, ...]:
        """The strand, leader first; empty until all are in place."""
        strand = self._roster.strand
        return strand if len(strand) == len(self.members) else ()

    @property
    def sensed(self) -> bool:
        """Whether a scan has been taken for the order."""
        return self._announcer.said.obstacle_m is not None

    @property
    def may_lead(self) -> bool:
        """Whether this robot leads and all have confirmed the strand."""
        return self.order[:1] == (self._robot,) and self._roster.agreed()

    def beside(self) -> list[Floats]:
        """Ground (n, 2) that each of the others may be on: where it stands."""
        if self._roster.places is None:
            return []
        return [np.repeat(place[None], 2, axis=0) for place in self._announcer.xy_of(self._announcer.others)]

    def give_up_step(self, driver: Driver) -> None:
        """Have the step in hand end where the robot comes to stand."""
        self._taking.give_up_step(driver)

    def wants_scan(self, driver: Driver) -> bool:
        """Rule 2."""
        if self.look is None and (self._needs_obstacle or self._needs_leg):
            return True
        return self._may_drive and self._taking.wants_scan(driver, self._now_s)

    def hear(self, robot: int, muster: Muster, now_s: float) -> None:
        """Take in what another robot announces; in another lining up it is void."""
        if robot in self._shunned or muster.members != self._announcer.said.members:
            return
        if robot != self._robot and muster.epoch == self.epoch and self._roster.hear(robot, muster):
            at_s = max(now_s, muster.t_s)
            gap_s = at_s - self._heard_at_s.get(robot, at_s)
            self._gaps_s[robot] = max(gap_s, self._gaps_s.get(robot, 0.0))
            self._heard_at_s[robot] = at_s

    def heard_at_s(self, robot: int) -> float:
        """When a member was heard last, or this lining up began."""
        return self._heard_at_s.get(robot, self.began_s)

    def gap_s(self, *, beside: int) -> float:
        """For how long, at most, one of the others was not heard and then was."""
        return max((gap_s for robot, gap_s in self._gaps_s.items() if robot != beside), default=0.0)

    def missed_s(self, robot: int, now_s: float) -> float:
        """For how long, at most, a member was not heard; a robot always hears itself."""
        if robot == self._robot:
            return 0.0
        return max(self._gaps_s.get(robot, 0.0), now_s - self.heard_at_s(robot))

    def stalled(self, now_s: float, *, late_s: float = 0.0) -> int | None:
        """Who keeps the others waiting for long, or so much longer, and may be deaf."""
        return self._waiting.stalled(now_s, free_at_s=self.free_at_s, late_s=late_s)

    def unheard_pairs(self) -> set[tuple[int, int]]:
        """Which members have not heard which, as they say; who has said nothing has heard nobody."""
        heard = self._roster.heard
        return {
            (one, other)
            for one in self.members
            for other in self.members
            if one != other and (one not in heard or other not in heard[one].hears)
        }

    def act(self, driver: Driver, scan: View | None, now_s: float) -> list[Command]:
        """Sense, take a turn or give one, and announce what is new.

        Args:
            driver: the robot's own.
            scan: one that was taken where the robot stands, if there is a new one.
            now_s: the time.
        """
        self._waiting.note(now_s)
        self._now_s = now_s
        announcer, pose = self._announcer, driver.odometry.pose
        if not announcer.has_spoken and not driver.standing:
            return []
        if not announcer.has_spoken:
            # At once: the order may depend on both.
            announcer.say(pose=pose, formers=tuple(berth.former(pose) for berth in self._berths))
        if announcer.own_turn is None:
            announcer.say(pose=pose)
        if announcer.said.members:
            announcer.say(hears=tuple(sorted(self._roster.heard)), free_s=self.settled_at_s)
        self._sense(scan)
        commands = self._taking.take(driver, self._trusted(scan), now_s, may_drive=self._may_drive)
        commands += self._giving.give(now_s)
        turn = self._roster.turn
        order = () if self.free_at_s is None else self.order
        announcer.say(turn=turn.number if turn is not None else 0, order=order)
        return commands + announcer.announce(now_s)

    # --- rule 2 -------------------------------------------------------------------------------------

    @property
    def _needs_obstacle(self) -> bool:
        return self._mission.goal is None and self._roster.places is not None and not self.sensed

    @property
    def _needs_leg(self) -> bool:
        """Whether the order of the start is known, but not yet whether this robot's leg in it is clear."""
        order = self._roster.start_order
        looks = self._mission.law.promises_clearance and order[:1] != (self._robot,)
        return bool(order) and self._announcer.said.leg_clear is None and looks

    def _sense(self, scan: View | None) -> None:
        announcer = self._announcer
        if scan is not None and (self._needs_obstacle or self._needs_leg):
            announcer.look = without_hulls(scan, announcer.xy_of(announcer.others), self._mission)
        if self._needs_obstacle and self.look is not None:
            nearest_m = self.look.nearest_m
            announcer.say(obstacle_m=self._mission.range_m_max if nearest_m is None else nearest_m)
        order = self._roster.start_order
        leg = self._former_leg(order) if self._needs_leg else None
        if leg is not None:
            self._leg_is_driven = True
            announcer.say(leg_clear=True, leg=leg)
        elif self._needs_leg and self.look is not None:
            ahead = announcer.xy_of([order[order.index(self._robot) - 1]])[0]
            announcer.say(leg_clear=leg_is_clear(self.look, ahead, self._mission))
        elif order and announcer.said.leg_clear is None and not self._needs_leg:
            announcer.say(leg_clear=True)

    def _former_leg(self, order: tuple[int, ...]) -> tuple[Point, ...] | None:
        """Corners of the way that the robot ahead has driven, where both still stand on it."""
        ahead = order[order.index(self._robot) - 1]
        stay = self._roster.stay(self._robot, ahead)
        if stay is None:
            return None
        own, theirs = stay
        berth = next(berth for berth in self._berths if berth.epoch == own.epoch)
        return berth.leg(own.progress_m, theirs.progress_m)

    # --- rules 4 and 5 -------------------------------------------------------------------------------

    def _trusted(self, scan: View | None) -> View | None:
        """A scan to drive by: it shows whoever is left out where that one stands."""
        fresh = scan is not None and self.free_at_s is not None and scan.t_s >= self.free_at_s
        return scan if fresh else None

    @property
    def _may_drive(self) -> bool:
        turn, free_at_s = self._announcer.own_turn, self.free_at_s
        if turn is None or free_at_s is None or self._now_s < free_at_s:
            return False
        since_s = self._now_s - self._mission.silence_s
        return self._roster.all_stand_in(turn, since_s=since_s, now_s=self._now_s)
