"""The strand that a coordinator drafts: its order, the robots in place, the next turn. Pure.

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
        waits for them before that, once.
Rule 5: where a robot that asks a strand on its way to let it in finds no way, the strand goes on as it was.
Rule 6: a leader that has arrived goes on to nowhere. So those without a way are let in before the last in
        place, which comes behind them then. If none finds a way so either, it keeps its place.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np

from agents.coordinating.folding import line_of, robots_in_place
from agents.coordinating.order import (
    former_order,
    in_front,
    kept_order,
    order_at_start,
    other_order,
    places_of,
    positions,
)
from agents.coordinating.questions import points
from agents.liveness.timing import Timing
from protocol.fence import Cause
from protocol.frames import Point
from protocol.mission import Mission
from protocol.wire.view import Join, Look, Report


class NoTurn(Enum):
    """What is to be done where no robot gets the turn."""

    WAIT = auto()  # nothing now
    BEGIN = auto()  # another order is to be tried
    DONE = auto()  # those in place are the strand; the others are left out


@dataclass(slots=True)
class Draft:
    """One coordinator's draft."""

    mission: Mission
    timing: Timing
    cause: Cause
    """Why there is a view."""
    led: tuple[int, ...] = ()
    """The robots that lead only after all others: they have led in vain, in this view or before."""
    order: tuple[int, ...] = ()
    strand: list[int] = field(default_factory=list)
    """The robots in place, leader first."""
    legs: dict[int, tuple[Point, ...]] = field(default_factory=dict)
    """Those that the robot ahead has driven, by the robot behind."""
    _stayed: tuple[int, ...] = ()
    _holds: int = 0  # so many have to be in place for the order that is tried
    _trial: bool = True
    _in_vain: dict[int, tuple[int, ...]] = field(default_factory=dict)  # behind which strand, by robot
    _makes_room: bool = False
    """Whether the last in place lets others in before it (rule 6)."""
    _made_room: int = 1
    """How many were in place when it last did; it does again when more are."""
    _stuck_at_s: float | None = None
    """When nobody found a way for the first time in this view: others are waited for once."""

    @property
    def keeps(self) -> bool:
        """Whether places in former strands count; not where a strand has dissolved."""
        return self.cause is not Cause.BLOCKED

    @property
    def front(self) -> list[int]:
        """Those in place behind which a robot joins: all, or all but the last (rule 6)."""
        return self.strand[:-1] if self._makes_room else self.strand

    @property
    def tried(self) -> frozenset[int]:
        """Who has had a turn in vain behind this very strand."""
        front = tuple(self.front)
        return frozenset(robot for robot, behind in self._in_vain.items() if behind == front)

    def begin(self, reports: Mapping[int, Report], obstacle_m: Mapping[int, float]) -> None:
        """Compute the order of those that have reported; who is in place is known when they have looked."""
        places = places_of(reports)
        stayed = self.strand
        if not stayed and self.keeps and not self.led:
            stayed = former_order(reports)
        self._stayed, self._holds, self._makes_room = (), 0, False
        if self.led and not self.strand:
            self.order = other_order(places, self.led, self.mission.goal)
        elif stayed:
            self.order = self._order_of(reports, stayed)
        else:
            self.order = order_at_start(places, self.mission.goal, obstacle_m)

    def _order_of(self, reports: Mapping[int, Report], stayed: Sequence[int]) -> tuple[int, ...]:
        """The order in which these stay, with others before them if nobody has to move."""
        self._stayed, places = tuple(stayed), places_of(reports)
        if not self._trial:
            return kept_order(places, stayed, ())
        order = kept_order(places, stayed, in_front(places, stayed, self.mission.goal))
        until = 1 + max(order.index(robot) for robot in stayed)
        self._holds = until if until > len(stayed) else 0
        return order

    def forget_order(self) -> None:
        """The order is to be computed anew, when robots have looked around."""
        self.order = ()

    def admit(self) -> None:
        """Another robot has reported: it may stand in front."""
        self._trial = True

    def settle(self, reports: Mapping[int, Report], sees: Callable[[int], Look]) -> bool:
        """Rule 1, from what robots see of their legs; False: the order needs somebody to move in front."""
        clear = 1
        while clear < len(self.order) and sees(self.order[clear]).clear:
            clear += 1
        order = self.order[:clear]
        self.legs = {robot: sees(robot).way for robot in order[1:] if sees(robot).driven}
        count = robots_in_place(places_of(reports), order, self.legs, self.mission)
        if count < self._holds:
            self._trial = False
            return False
        self.strand = list(self.order[:count])
        return True

    def join(self, robot: int, reports: Mapping[int, Report], turn: int) -> Join:
        """Where the strand ends that the robot joins in this turn, and where the other robots stand."""
        strand, places = self.front, places_of(reports)
        line, leg = line_of(places, strand, self.legs)
        waiting = [other for other in places if other != robot and other not in strand]
        return Join(
            turn=turn,
            strand=points(positions(places, strand)),
            waiting=points(positions(places, waiting)),
            robots=tuple(sorted((*strand, *waiting))),
            line=points(line),
            last_leg=int((leg == leg[-1]).sum()) if len(leg) else 0,
        )

    def end_turn(self, robot: int, *, placed: bool) -> None:
        """A robot has ended its turn, in place or in vain, or has lost it."""
        self.legs.pop(robot, None)
        if not placed:
            self._in_vain.pop(robot, None)  # so that the newest stands last
            self._in_vain[robot] = tuple(self.front)
        else:
            self.strand, self._makes_room = [*self.front, robot], False

    def next(
        self, reports: Mapping[int, Report], now_s: float, *, others_may_come_back: bool
    ) -> int | NoTurn:
        """The robot that gets the turn (rules 2 to 6)."""
        waiting = [robot for robot in sorted(reports) if robot not in self.strand]
        if not waiting:
            return NoTurn.DONE
        free = sorted({*waiting} - self.tried)
        if free and all(robot in self._in_vain for robot in free):
            return next(robot for robot in reversed(self._in_vain) if robot in free)
        if free:
            places = places_of(reports)
            off_m = np.hypot(*(positions(places, free) - positions(places, self.front[-1:])).T)
            return free[int(np.argmin(off_m))]
        goes_on = self.cause is Cause.PLEA and not reports[self.strand[0]].arrived
        if goes_on and self._stayed and set(self._stayed) <= set(self.strand):
            return NoTurn.DONE
        return self._give_up(reports, now_s, others_may_come_back=others_may_come_back)

    def _give_up(
        self, reports: Mapping[int, Report], now_s: float, *, others_may_come_back: bool
    ) -> int | NoTurn:
        """Rules 3, 4 and 6."""
        places = places_of(reports)
        self._stuck_at_s = now_s if self._stuck_at_s is None else self._stuck_at_s
        is_new = now_s - self._stuck_at_s < self.timing.comes_back_s
        if is_new and others_may_come_back:
            return NoTurn.WAIT
        goal, leader = self.mission.goal, self.strand[0]
        if goal is None or other_order(places, self.led, goal)[0] == leader:
            if not reports[leader].arrived or len(self.strand) <= self._made_room:
                return NoTurn.DONE
            self._makes_room, self._made_room = True, len(self.strand)
            return self.next(reports, now_s, others_may_come_back=others_may_come_back)
        self.led, self.strand, self._trial = (*self.led, leader), [], False
        self._in_vain.clear()
        return NoTurn.BEGIN

    def drop(self, robot: int) -> None:
        """A robot is no longer in place, if it was."""
        self.strand = [each for each in self.strand if each != robot]
