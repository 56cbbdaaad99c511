"""Lining up: who leads, and in which order the others follow. Pure, and the same at every robot.

Rule 1: every robot announces its place; without a goal its distance to the nearest obstacle too; then the
        order that it computed.
Rule 2: without a goal the leader is the robot nearest to an obstacle (3), ties by lowest number.
Rule 3: with a goal, (3) may elect a robot at the far end, which would have to lead through its own
        fleet. Then it is one of three, the robot nearest to the goal and both ends of its strand: the
        one whose strand has the least way to drive until its tail is at the goal.
Rule 4: from the leader on, each next place goes to the nearest robot not yet placed (section III-C),
        ties by lowest number.
Rule 5: all compute the order from the same roster; the leader starts when all have announced the same.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from protocol.arrays import distances_to_segments, segments_apart
from protocol.frames import Point, Pose
from protocol.messages import Muster

Places = Mapping[int, Pose]


def chain(places: Places, leader: int) -> tuple[int, ...]:
    """Rule 4: the strand behind a leader."""
    order = [leader]
    waiting = sorted(set(places) - {leader})
    while waiting:
        last = places[order[-1]]
        nearest = min(waiting, key=lambda robot: (_apart_m(last, places[robot]), robot))
        order.append(nearest)
        waiting.remove(nearest)
    return tuple(order)


def order_without_goal(places: Places, obstacle_m: Mapping[int, float]) -> tuple[int, ...]:
    """Rules 2 and 4."""
    return chain(places, min(places, key=lambda robot: (obstacle_m[robot], robot)))


def order_with_goal(places: Places, goal: Point) -> tuple[int, ...]:
    """Rules 3 and 4."""

    def to_goal_m(robot: int) -> float:
        return math.hypot(places[robot].x_m - goal.x_m, places[robot].y_m - goal.y_m)

    def way_m(order: Sequence[int]) -> float:
        links = pairwise(order)
        return sum(_apart_m(places[a], places[b]) for a, b in links) + to_goal_m(order[0])

    nearest = chain(places, min(places, key=lambda robot: (to_goal_m(robot), robot)))
    from_its_end = chain(places, nearest[-1])
    candidates = (nearest, from_its_end, chain(places, from_its_end[-1]))
    return min(candidates, key=lambda order: (way_m(order), order[0]))


def folds_back(places: Places, order: Sequence[int], *, least_m: float) -> bool:
    """Whether the way of one robot to the front leads nearer than this past another that stands.

    Then ground that robots behind may be on is not apart, from the start, from ground that the ones ahead
    have still to drive: no two legs of the way that are not neighbours may be so near, nor its two ends.
    """
    line = np.array([(places[robot].x_m, places[robot].y_m) for robot in order])
    starts, ends = line[:-1], line[1:]
    if len(starts) == 0:
        return False
    legs_m = segments_apart(starts[:, None], ends[:, None], starts[None], ends[None])
    apart = [
        np.hypot(*(ends - starts).T),
        legs_m[np.triu_indices(len(starts), k=2)],
        distances_to_segments(line[0], starts[1:], ends[1:]),
        distances_to_segments(line[-1], starts[:-1], ends[:-1]),
    ]
    return bool(np.concatenate(apart).min() < least_m)


def _apart_m(a: Pose, b: Pose) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)


@dataclass(slots=True)
class Roster:
    """What one robot knows of the lining up."""

    robots: int
    goal: Point | None
    heard: dict[int, Muster] = field(default_factory=dict)
    _order: tuple[int, ...] | None = None
    """What is asked for at every event takes 1 s to compute for 1000 robots, so it is kept."""

    def hear(self, robot: int, muster: Muster) -> None:
        """Take in an announcement. One that knows less than an earlier one is late and changes nothing."""
        known = self.heard.get(robot)
        if 1 <= robot <= self.robots and (known is None or _knows(muster) >= _knows(known)):
            self.heard[robot] = muster
            if known is None or (known.pose, known.obstacle_m) != (muster.pose, muster.obstacle_m):
                self._order = None

    @property
    def places(self) -> dict[int, Pose] | None:
        """Where all robots stand; None until all have been heard."""
        if len(self.heard) < self.robots:
            return None
        return {robot: muster.pose for robot, muster in sorted(self.heard.items())}

    def order(self) -> tuple[int, ...]:
        """The strand, leader first; empty until enough is known."""
        if self._order is None:
            self._order = self._compute_order()
        return self._order

    def _compute_order(self) -> tuple[int, ...]:
        places = self.places
        if places is None:
            return ()
        if self.goal is not None:
            return order_with_goal(places, self.goal)
        obstacle_m = {robot: muster.obstacle_m for robot, muster in self.heard.items()}
        known_m = {robot: metres for robot, metres in obstacle_m.items() if metres is not None}
        return order_without_goal(places, known_m) if len(known_m) == self.robots else ()

    def agreed(self) -> bool:
        """Rule 5: whether all have announced the order that this roster gives."""
        order = self.order()
        return bool(order) and all(muster.order == order for muster in self.heard.values())


def _knows(muster: Muster) -> tuple[bool, bool]:
    return muster.obstacle_m is not None, bool(muster.order)
