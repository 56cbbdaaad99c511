"""Lining up: who leads, in which order the others follow, who is in place. Pure, and the same at every robot.

Rule 1: without a goal the leader is the robot nearest to an obstacle (3), ties by lowest number.
Rule 2: with a goal, (3) may elect a robot at the far end, which would have to lead through its own
        fleet. Then it is one of three, the robot nearest to the goal and both ends of its strand: the
        one whose strand has the least way to drive until its tail is at the goal.
Rule 3: from the leader on, each next place goes to the nearest robot not yet placed (section III-C),
        ties by lowest number. This is the order of the start; it stays as it is once it can be known.
        In a muster that was called, those who still stand at their places in the newest strand go first, in
        its order; but at first one is tried where those lead that stand nearer to its front than to its end,
        if nobody has to move for it. Where orders have been tried in vain, the one leads that is nearest to
        the goal of those who have not yet.
Rule 4: in place are, from the front on, as many of that order as have a clear leg to the robot ahead that
        does not fold back, or still stand behind it in the strand that they were in; then those that came
        to a place by a turn. Who has ended a turn is no more where it stood at the start.
Rule 5: the leader starts when all have announced the same strand.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product, takewhile

import numpy as np

from protocol.arrays import Floats, Indices, distances_to_segments, segments_apart
from protocol.frames import Point, Pose
from protocol.wire.messages import FIRST_ATTEMPT, Attempt, Former, Muster, Turn

Places = Mapping[int, Pose]
Legs = Mapping[int, Sequence[Point]]
"""Corners of a robot's way to the one ahead, by robot; who is not named goes straight."""
NO_LEGS: Legs = {}
ORDERS_MAX = 5  # each takes as long as all turns of it


def chain(places: Places, leader: int) -> tuple[int, ...]:
    """Rule 3: the strand behind a leader."""
    order = [leader]
    waiting = sorted(set(places) - {leader})
    while waiting:
        last = places[order[-1]]
        nearest = min(waiting, key=lambda robot: (_apart_m(last, places[robot]), robot))
        order.append(nearest)
        waiting.remove(nearest)
    return tuple(order)


def is_order(attempt: Attempt, robots: int) -> bool:
    """Whether so many robots have an order that is still to be tried."""
    return len(attempt.led) < min(ORDERS_MAX, robots)


def order_without_goal(places: Places, obstacle_m: Mapping[int, float]) -> tuple[int, ...]:
    """Rules 1 and 3."""
    return chain(places, min(places, key=lambda robot: (obstacle_m[robot], robot)))


def nearest_to(goal: Point | None, places: Places) -> int:
    """Who is nearest to a goal, ties by lowest number; without a goal the lowest number."""

    def to_goal_m(robot: int) -> float:
        return 0.0 if goal is None else _apart_m(places[robot], goal)

    return min(places, key=lambda robot: (to_goal_m(robot), robot))


def order_with_goal(places: Places, goal: Point) -> tuple[int, ...]:
    """Rules 2 and 3."""

    def way_m(order: Sequence[int]) -> float:
        links = pairwise(order)
        return sum(_apart_m(places[a], places[b]) for a, b in links) + _apart_m(places[order[0]], goal)

    nearest = chain(places, nearest_to(goal, places))
    from_its_end = chain(places, nearest[-1])
    candidates = (nearest, from_its_end, chain(places, from_its_end[-1]))
    return min(candidates, key=lambda order: (way_m(order), order[0]))


def folds_back(places: Places, order: Sequence[int], *, least_m: float, legs: Legs = NO_LEGS) -> bool:
    """Whether the way of one robot to the front leads nearer than this past another that stands.

    Then ground that robots behind may be on is not apart, from the start, from ground that the ones ahead
    have still to drive: no two legs of the way that are not neighbours may be so near, nor its two ends.
    """
    if len(order) < 2:
        return False
    stands = np.array([(places[robot].x_m, places[robot].y_m) for robot in order])
    line, leg = line_of(places, order, legs)
    starts, ends = line[:-1], line[1:]
    near_m = segments_apart(starts[:, None], ends[:, None], starts[None], ends[None])
    apart = [
        np.hypot(*np.diff(stands, axis=0).T),
        near_m[leg[None] - leg[:, None] >= 2],
        distances_to_segments(line[0], starts[leg >= 1], ends[leg >= 1]),
        distances_to_segments(line[-1], starts[leg < leg[-1]], ends[leg < leg[-1]]),
    ]
    return bool(np.concatenate(apart).min() < least_m)


def line_of(places: Places, order: Sequence[int], legs: Legs) -> tuple[Floats, Indices]:
    """The way from the first of an order to its last (n, 2), and which leg each segment is of (n - 1,)."""
    corners: list[Point | Pose] = [places[order[0]]]
    leg: list[int] = []
    for index, robot in enumerate(order[1:]):
        corners += [*reversed(legs.get(robot, ())), places[robot]]
        leg += [index] * (len(corners) - 1 - len(leg))
    return np.array([(corner.x_m, corner.y_m) for corner in corners]), np.array(leg, dtype=np.intp)


def in_place_at_start(places: Places, order: Sequence[int], *, least_m: float, legs: Legs = NO_LEGS) -> int:
    """How many robots of an order, from the front on, stand so that it does not fold back.

    A strand that folds back does so however many join it, so this is found by halves.
    """
    if not folds_back(places, order, least_m=least_m, legs=legs):
        return len(order)
    low, high = 1, len(order)
    while high - low > 1:
        middle = (low + high) // 2
        if folds_back(places, order[:middle], least_m=least_m, legs=legs):
            high = middle
        else:
            low = middle
    return low


def _apart_m(a: Pose, b: Pose | Point) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)


@dataclass(slots=True)
class Roster:
    """What one robot knows of the lining up, its own announcements included."""

    members: tuple[int, ...]
    """Who lines up, in ascending order."""
    goal: Point | None
    least_m: float
    """Least distance between the centres of two robots in the strand."""
    attempt: Attempt = FIRST_ATTEMPT
    heard: dict[int, Muster] = field(default_factory=dict)
    start_order: tuple[int, ...] = ()
    """Rule 3, leader first; empty until it can be known."""
    _at_start: int = 0
    """How many were in place before anybody moved; 0 until that is known."""
    in_front: tuple[int, ...] = ()
    """Rule 3: who leads those who have stayed, in the order that is tried at first."""
    _stayed: tuple[int, ...] = ()

    def hear(self, robot: int, muster: Muster) -> bool:
        """Take in an announcement; whether it is newer than what was known."""
        known = self.heard.get(robot)
        if robot not in self.members or (known is not None and muster.number <= known.number):
            return False
        self.heard[robot] = muster
        self.start_order = self.start_order or self._compute_order()
        if self.start_order and not self._at_start:
            self._at_start = self._count_at_start()
        return True

    @property
    def places(self) -> dict[int, Pose] | None:
        """Where all robots stand; None until all have been heard."""
        if len(self.heard) < len(self.members):
            return None
        return {robot: muster.pose for robot, muster in sorted(self.heard.items())}

    @property
    def free_at_s(self) -> float | None:
        """The latest time at which a member knows all who are left out to stand; None until all have said."""
        free_s = [muster.free_s for muster in self.heard.values() if muster.free_s is not None]
        return max(free_s) if len(free_s) == len(self.members) else None

    @property
    def strand(self) -> tuple[int, ...]:
        """Rule 4: who is in place, leader first; empty until all have looked at their legs."""
        at_start = self.start_order[: self._at_start]
        placed = list(takewhile(lambda robot: self.heard[robot].ended == 0, at_start))
        by_rank = {muster.rank: robot for robot, muster in self.heard.items() if muster.rank is not None}
        while len(placed) in by_rank:
            placed.append(by_rank[len(placed)])
        return tuple(placed)

    @property
    def turn(self) -> Turn | None:
        """The newest turn that has been given."""
        given = [muster.gives for muster in self.heard.values() if muster.gives is not None]
        return max(given, key=lambda turn: turn.number, default=None)

    def giver(self, turn: Turn) -> int:
        """Who gave a turn."""
        return next(robot for robot, muster in self.heard.items() if muster.gives == turn)

    def all_stand_in(self, turn: Turn, *, since_s: float, now_s: float) -> bool:
        """Whether every other robot has said that it stands in this turn, in answer to what is so new.

        Times are by the clock of whoever has the turn; nothing that it is yet to say can have been answered.
        """
        others = [muster for robot, muster in self.heard.items() if robot != turn.robot]
        return len(others) == len(self.members) - 1 and all(
            muster.turn >= turn.number and since_s <= muster.echo_s <= now_s for muster in others
        )

    def mover_said_s(self, until_s: float) -> float:
        """When whoever has the turn said the newest thing that is known of, by its clock; 0: nothing.

        From that robot, or from one that has heard it: who misses much of what one says may hear another. An
        echo of what is said only after `until_s` is not passed on: it would be answered for ever.
        """
        turn = self.turn
        if turn is None:
            return 0.0
        mover = self.heard.get(turn.robot)
        echoes = [muster.echo_s for muster in self.heard.values() if muster.turn == turn.number]
        heard_s = [echo_s for echo_s in echoes if echo_s <= until_s]
        return max([0.0 if mover is None else mover.t_s, *heard_s])

    def agreed(self) -> bool:
        """Rule 5: whether all have announced the strand that this roster gives."""
        strand = self.strand
        return len(strand) == len(self.members) and all(
            muster.order == strand for muster in self.heard.values()
        )

    @property
    def legs(self) -> Legs:
        """The legs that are not straight, of robots that have stayed where they were."""
        return {robot: muster.leg for robot, muster in self.heard.items() if muster.leg and not muster.ended}

    def stay(self, robot: int, ahead: int) -> tuple[Former, Former] | None:
        """Where two stand that were one behind the other in a strand, and have not left their places."""
        for own, theirs in product(self.heard[robot].formers, self.heard[ahead].formers):
            near = own.epoch == theirs.epoch and own.rank == theirs.rank + 1
            if near and own.progress_m <= theirs.progress_m:
                return own, theirs
        return None

    @property
    def next_attempt(self) -> Attempt:
        """What is left to try when this order has been tried in vain; to be asked when it is known."""
        leader = () if self.in_front else self.start_order[:1]
        return Attempt(trial=False, led=self.attempt.led + leader)

    @property
    def trial_failed(self) -> bool:
        """Rule 3: whether somebody would have to move for the order that is tried at first."""
        kept = len(self.in_front) + len(self._stayed)
        return bool(self.in_front) and 0 < self._at_start < kept

    def leads_on(self, strand: tuple[int, ...]) -> bool:
        """Whether those in place are more than half, and of all their leader is the nearest to the goal."""
        places = self.places
        if 2 * len(strand) <= len(self.members) or places is None or self.goal is None:
            return False
        return strand[0] == nearest_to(self.goal, places)

    @property
    def leads_next(self) -> int | None:
        """Who would lead the next order and stands in front, nearer to the goal than the leader of this."""
        places = self.places
        if places is None or self.goal is None or not is_order(self.next_attempt, len(self.members)):
            return None
        nearest = nearest_to(self.goal, self._not_yet_led(places))
        return None if nearest == self.start_order[0] else nearest

    def _not_yet_led(self, places: Places) -> Places:
        """Who has not led in vain; all where that is nobody, since whoever it was may have gone."""
        waiting = {robot: pose for robot, pose in places.items() if robot not in self.attempt.led}
        return waiting or places

    def _other_order(self, places: Places) -> tuple[int, ...]:
        """Rule 3, where an order has been tried in vain."""
        return chain(places, nearest_to(self.goal, self._not_yet_led(places)))

    def _former_order(self, places: Places) -> tuple[int, ...]:
        """Rule 3, in a muster that was called."""
        newest = max((former.epoch for muster in self.heard.values() for former in muster.formers), default=0)
        ranked = {
            former.rank: robot
            for robot, muster in self.heard.items()
            for former in muster.formers
            if former.epoch == newest
        }
        if not ranked:
            return ()
        self._stayed = stayed = tuple(ranked[rank] for rank in sorted(ranked))
        rest = {robot: pose for robot, pose in places.items() if robot not in stayed}
        if self.attempt.trial:
            front = {robot: pose for robot, pose in rest.items() if self._is_in_front(pose, places)}
            self.in_front = chain({**front, stayed[0]: places[stayed[0]]}, stayed[0])[:0:-1]
        back = {robot: pose for robot, pose in rest.items() if robot not in self.in_front}
        return self.in_front + stayed[:-1] + chain({**back, stayed[-1]: places[stayed[-1]]}, stayed[-1])

    def _is_in_front(self, pose: Pose, places: Places) -> bool:
        """Whether a robot stands nearer to the front of those who have stayed than to their end."""
        first, last = places[self._stayed[0]], places[self._stayed[-1]]
        if len(self._stayed) > 1:
            return _apart_m(pose, first) < _apart_m(pose, last)
        return self.goal is not None and _apart_m(pose, self.goal) < _apart_m(first, self.goal)

    def _compute_order(self) -> tuple[int, ...]:
        places = self.places
        if places is None:
            return ()
        if self.attempt.led:
            return self._other_order(places)
        if former := self._former_order(places):
            return former
        if self.goal is not None:
            return order_with_goal(places, self.goal)
        obstacle_m = {robot: muster.obstacle_m for robot, muster in self.heard.items()}
        known_m = {robot: metres for robot, metres in obstacle_m.items() if metres is not None}
        return order_without_goal(places, known_m) if len(known_m) == len(self.members) else ()

    def _count_at_start(self) -> int:
        legs = [self.heard[robot].leg_clear for robot in self.start_order]
        if None in legs:
            return 0
        clear = legs.index(False) if False in legs else len(legs)
        places = {robot: muster.pose for robot, muster in self.heard.items()}
        apart = in_place_at_start(places, self.start_order[:clear], least_m=self.least_m, legs=self.legs)
        if self.in_front:
            return apart
        stay = takewhile(lambda pair: self.stay(pair[1], pair[0]), pairwise(self.start_order[:clear]))
        return max(apart, 1 + sum(1 for _ in stay))
