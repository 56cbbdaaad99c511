"""The strand that a coordinator drafts: its order, the robots in place, the next turn. Pure.

A draft remembers only facts of its view: the robots in place, those that have led in vain, and the orders and
turns that were in vain.

Rule 1: two groups are in place. First, from the front on, the robots of the order that have a clear leg to
        the robot ahead, as long as their strand does not fold back (`agents.coordinating.folding`). Then
        those that came to a place by a turn.
Rule 2: the turn goes to the nearest robot that is not in place and has not had one in vain behind this very
        strand. Behind another one it may find a way. A draft that begins again with the same strand does not
        repeat what was in vain. Where all that are left had one in vain, the last of them is first: in a
        queue whose end has come in, it has room to move now.
Rule 3: if no robot finds a way, and another one, not among the last to lead, is nearer to the goal than the
        leader, that one leads. Else those in place go on: then the others may find a way.
Rule 4: robots that are left out and were there lately may stand in the way, and may come back. So the draft
        waits for them before that.
Rule 5: where a robot that asks a strand on its way to let it in finds no way, the strand goes on as it was.
"""

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np

from agents.coordinating.folding import line_of, robots_in_place
from agents.coordinating.order import (
    Reports,
    former_order,
    in_front,
    kept_order,
    order_at_start,
    other_order,
    places_of,
    positions,
)
from protocol.arrays import points_of
from protocol.fence import Cause
from protocol.frames import Point
from protocol.mission import Mission
from protocol.wire.view import Join, Look

Order = tuple[int, ...]
"""Robots, leader first."""


class NoTurn(Enum):
    """What is to be done where no robot gets the turn."""

    WAIT = auto()  # nothing now
    BEGIN = auto()  # another order is to be tried
    DONE = auto()  # those in place are the strand; the others are left out


@dataclass(frozen=True, slots=True)
class Drafted:
    """For people: a draft, or the formation that was made of it."""

    order: Order
    """The order that is tried, leader first; of a strand that turns round none."""
    in_place: Order
    """The strand as far as it stands, leader first."""
    left_out: Mapping[int, str]
    """Why each other robot has no place."""
    awaited: Set[int]
    """The robots that the view waits for in its phase."""
    since_s: float
    """When that phase began."""


@dataclass(slots=True)
class Draft:
    """One coordinator's draft."""

    mission: Mission
    cause: Cause
    led: tuple[int, ...] = ()
    """The robots that lead only after all others: they have led in vain, in this view or before."""
    order: Order = ()
    """The order that is tried."""
    strand: Order = ()
    """The robots in place (rule 1)."""
    legs: dict[int, tuple[Point, ...]] = field(default_factory=dict)
    """Those that the robot ahead has driven, by the robot behind."""
    _stayed: Order = ()
    """Those that were in place before the order was tried, here or in a former strand."""
    _orders_in_vain: set[Order] = field(default_factory=set)
    """Orders with others before those that stayed, for which one of these would have to move."""
    _turns_in_vain: list[tuple[int, Order]] = field(default_factory=list)
    """A robot, and the strand behind which it found no way; under this leader, oldest first."""

    @property
    def keeps(self) -> bool:
        """Whether places in former strands count; not where a strand has dissolved."""
        return self.cause is not Cause.BLOCKED

    @property
    def tried(self) -> set[int]:
        """The robots that have had a turn in vain behind this very strand."""
        return {robot for robot, behind in self._turns_in_vain if behind == self.strand}

    def begin(self, reports: Reports, obstacle_m: Mapping[int, float], led: tuple[int, ...]) -> None:
        """Compute the order of the robots that have reported. `settle` finds those in place, after all looks.

        `obstacle_m`: without a goal, each robot's distance from the nearest obstacle; empty: no order before
        they have looked around. `led`: the robots that lead only after all others, as counted before.
        """
        places, goal = places_of(reports), self.mission.goal
        self.led = self.led or led
        self._stayed = self.strand or (former_order(reports) if self.keeps and not self.led else ())
        if goal is None and not obstacle_m:
            self.order = ()
        elif self._stayed:
            self.order = kept_order(places, self._stayed, in_front(places, self._stayed, goal))
            if self.order in self._orders_in_vain:
                self.order = kept_order(places, self._stayed, ())
        elif self.led:
            self.order = other_order(places, self.led, goal)
        else:
            self.order = order_at_start(places, goal, obstacle_m)

    def settle(self, reports: Reports, sees: Callable[[int], Look]) -> bool:
        """Rule 1, from what robots see of their legs; False: the order needs somebody to move in front."""
        clear = 1
        while clear < len(self.order) and sees(self.order[clear]).clear:
            clear += 1
        order = self.order[:clear]
        self.legs = {robot: sees(robot).way for robot in order[1:] if sees(robot).driven}
        in_place = order[: robots_in_place(places_of(reports), order, self.legs, self.mission)]
        others_lead = self.order[: len(self._stayed)] != self._stayed
        if others_lead and not {*self._stayed} <= {*in_place}:
            self._orders_in_vain.add(self.order)
            return False
        self.strand = in_place
        return True

    def join(self, robot: int, reports: Reports, turn: int) -> Join:
        """Where the strand ends that the robot joins in this turn, and where the other robots stand."""
        places, front = places_of(reports), self.strand
        line, leg = line_of(places, front, self.legs)
        waiting = [other for other in places if other != robot and other not in front]
        return Join(
            turn=turn,
            strand=points_of(positions(places, front)),
            waiting=points_of(positions(places, waiting)),
            robots=tuple(sorted((*front, *waiting))),
            line=points_of(line),
            last_leg=int((leg == leg[-1]).sum()) if len(leg) else 0,
        )

    def end_turn(self, robot: int, *, placed: bool) -> None:
        """A robot has ended its turn, in place or in vain, or has lost it."""
        self.legs.pop(robot, None)
        if placed:
            self.strand = (*self.strand, robot)
        else:
            self._turns_in_vain.append((robot, self.strand))

    def next(self, reports: Reports, *, others_may_come_back: bool) -> int | NoTurn:
        """The robot that gets the turn (rules 2 to 5)."""
        waiting, leader = reports.keys() - {*self.strand}, self.strand[0]
        if free := sorted(waiting - self.tried):
            return self._first_of(free, reports)
        is_as_it_was = bool(self._stayed) and {*self._stayed} <= {*self.strand}
        goes_on = self.cause is Cause.PLEA and not reports[leader].arrived and is_as_it_was
        if not waiting or goes_on:
            return NoTurn.DONE
        if others_may_come_back:
            return NoTurn.WAIT
        goal = self.mission.goal
        if goal is None or other_order(places_of(reports), self.led, goal)[0] == leader:
            return NoTurn.DONE
        self.led, self.strand, self._turns_in_vain = (*self.led, leader), (), []
        return NoTurn.BEGIN

    def _first_of(self, free: Sequence[int], reports: Reports) -> int:
        """Rule 2: which of these gets the turn."""
        newest_first = [robot for robot, _ in reversed(self._turns_in_vain) if robot in free]
        if {*free} <= {*newest_first}:
            return newest_first[0]
        places = places_of(reports)
        off_m = np.hypot(*(positions(places, free) - positions(places, self.strand[-1:])).T)
        return free[int(np.argmin(off_m))]

    def drop(self, robot: int) -> None:
        """A robot is no longer in place, if it was."""
        self.strand = tuple(each for each in self.strand if each != robot)
