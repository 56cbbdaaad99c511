"""Turns in a lining up, as the last robot in place gives them.

Rule 1: it gives a turn to the nearest that is not in place, those apart that it gave one in vain; it gives
        the next when that one has said that its turn has ended.
Rule 2: where all have had theirs in vain it gives its own place up, once, and the turn back to the robot
        ahead, which tries others first; the leader gives itself a turn, once, to go where others can come.
        In a muster that was called, and leaves nobody out, another order is tried at once if the one that
        would lead it stands in front, and is among those that find no way: they can come to it.
Rule 3: where that is in vain, too, those in place go on without the others, if they are more than half,
        nobody is nearer to the goal than their leader, and the last of them had not arrived there: there may
        be room farther on, and if there is none, they at least arrive. Else another order is tried.
"""

import numpy as np

from agents.commands import Command, Note
from agents.membership.announcer import Announcer
from agents.membership.muster import is_order
from agents.strand.strand import COMES_BACK_S
from protocol.mission import Mission
from protocol.timeline import RouteLost
from protocol.wire.messages import Turn

MAKES_WAY_S = 5.0  # a process that is started again is there after two


class Giving:
    """Which turns one robot gives."""

    def __init__(self, announcer: Announcer, mission: Mission, *, arrived: bool) -> None:
        self._announcer = announcer
        self._arrived = arrived
        self._mission = mission
        self._blocked: set[int] = set()
        self._gave_up = self._lost = False
        self.wants_another_order = False
        self.goes_on_with: tuple[int, ...] = ()
        """Rule 3: who is in place, leader first; empty as long as the others may still come."""
        self.others_may_come_back = True
        """Whether some of those that are left out may be lined up with again before long."""
        self.stuck_at_s: float | None = None
        """Since when nobody who remains finds a way to a place behind this robot, the last in place."""

    def begin(self) -> None:
        """This robot has just come to its place: those that were blocked may have a turn again."""
        self._blocked = set()

    def give(self, now_s: float) -> list[Command]:
        """Give the next turn, if it is this robot's to give."""
        announcer = self._announcer
        roster, said = announcer.roster, announcer.said
        if announcer.own_turn is not None:
            return []
        strand, given, newest = roster.strand, said.gives, roster.turn
        if strand[-1:] != (announcer.robot,) or len(strand) == len(roster.members) or self._lost:
            return []
        if newest is not None and newest.robot == announcer.robot and newest.number > said.ended:
            self._blocked = {roster.giver(newest)}  # it gave up its place for the others
        elif given is not None:
            theirs = roster.heard.get(given.robot)
            if theirs is None or theirs.ended < given.number:
                return []
            self._blocked.add(given.robot)
        if roster.trial_failed:
            self.wants_another_order = True
            return []
        number = 1 if newest is None else newest.number + 1
        waiting = [robot for robot in announcer.others if robot not in strand]
        free = [robot for robot in waiting if robot not in self._blocked]
        if not free:
            return self._give_up(strand, waiting, number, now_s)
        off_m = np.hypot(*(announcer.xy_of(free) - announcer.xy_of([announcer.robot])).T)
        announcer.say(gives=Turn(number=number, robot=free[int(np.argmin(off_m))]))
        return []

    def _give_up(
        self, strand: tuple[int, ...], waiting: list[int], number: int, now_s: float
    ) -> list[Command]:
        """Nobody can come to a place behind this robot: it makes way, or nobody ever will.

        Who is left out may stand in the way, and come back: it is waited for before anybody leaves a place.
        """
        announcer = self._announcer
        roster = announcer.roster
        all_are_here = len(roster.members) == self._mission.robots
        if announcer.said.members and all_are_here and roster.leads_next in waiting:
            self.wants_another_order = True
            return []
        self.stuck_at_s = now_s if self.stuck_at_s is None else self.stuck_at_s
        if not all_are_here and self.others_may_come_back:
            patience_s = COMES_BACK_S if self._gave_up else MAKES_WAY_S
            if now_s - self.stuck_at_s < patience_s:
                return []
        if not self._gave_up:
            self._gave_up, self._blocked = True, set()
            if len(strand) > 1:
                announcer.say(gives=Turn(number=number, robot=strand[-2]), ended=number, rank=None)
            else:
                announcer.say(gives=Turn(number=number, robot=announcer.robot))
            return []
        if not self._arrived and roster.leads_on(strand):
            self.goes_on_with = strand
            return []
        if is_order(roster.next_attempt, len(roster.members)):
            self.wants_another_order = True
            return []
        self._lost = True
        named = ", ".join(f"robot {robot}" for robot in waiting)
        return [Note(RouteLost(reason=f"no way to a place behind robot {announcer.robot} for {named}"))]
