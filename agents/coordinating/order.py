"""The order of a strand, computed from where its robots stand; section III-C of the paper. Pure.

Rule 1: without a goal the robot nearest to an obstacle leads (3). With a goal it is the one whose strand has
        the least way to drive until its tail is at the goal: the robot nearest to the goal, or either end of
        the strand behind that one. Ties go to the lowest number.
Rule 2: the robot next in the strand is the nearest one that is left (III-C).
Rule 3: robots that have not left their places in a former strand keep their order. Others that stand
        in front come in front, if no robot has to move for that. The rest come behind.
Rule 4: after an attempt in vain, the next leader is the one nearest to the goal that is not among the last to
        lead. If all are, it is the first of them: it may stand elsewhere now, and so may those in its way.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from protocol.arrays import Floats, places_xy
from protocol.frames import Point, Pose, apart_m
from protocol.wire.view import Report

Places = Mapping[int, Pose]
Reports = Mapping[int, Report]


def places_of(reports: Reports) -> Places:
    """Where the robots stand that have reported."""
    return {robot: report.place for robot, report in sorted(reports.items())}


def positions(places: Places, robots: Sequence[int]) -> Floats:
    """Where robots stand (n, 2) [world frame]."""
    return places_xy([places[robot] for robot in robots])


def chain(places: Places, leader: int) -> tuple[int, ...]:
    """Rule 2: the strand behind a leader."""
    robots = sorted(places)
    where = positions(places, robots)
    left = np.ones(len(robots), dtype=bool)
    order = [robots.index(leader)]
    left[order[0]] = False
    for _ in robots[1:]:
        off_m = np.where(left, np.hypot(*(where - where[order[-1]]).T), np.inf)
        order.append(int(np.argmin(off_m)))
        left[order[-1]] = False
    return tuple(robots[index] for index in order)


def nearest_to(goal: Point | None, places: Places) -> int:
    """The robot nearest to a goal; without a goal the lowest number."""
    return min(places, key=lambda robot: (0.0 if goal is None else apart_m(places[robot], goal), robot))


def order_at_start(places: Places, goal: Point | None, obstacle_m: Mapping[int, float]) -> tuple[int, ...]:
    """Rules 1 and 2; without a goal, `obstacle_m` is each robot's distance from the nearest obstacle."""
    if goal is None:
        return chain(places, min(places, key=lambda robot: (obstacle_m[robot], robot)))
    nearest = chain(places, nearest_to(goal, places))
    from_its_end = chain(places, nearest[-1])

    def way_m(order: tuple[int, ...]) -> float:
        links_m = np.hypot(*np.diff(positions(places, order), axis=0).T).sum()
        return float(links_m) + apart_m(places[order[0]], goal)

    candidates = (nearest, from_its_end, chain(places, from_its_end[-1]))
    return min(candidates, key=lambda order: (way_m(order), order[0]))


def former_order(reports: Reports) -> tuple[int, ...]:
    """Rule 3: the robots that stayed in the newest formation or draft in which any did, in its order."""
    ranks = {(former.epoch.number, robot): former.rank for robot, report in reports.items()
             for former in report.formers}  # fmt: skip
    newest = max((number for number, _ in ranks), default=0)
    stayed = {robot: rank for (number, robot), rank in ranks.items() if number == newest}
    return tuple(sorted(stayed, key=lambda robot: (stayed[robot], robot)))


def in_front(places: Places, stayed: Sequence[int], goal: Point | None) -> tuple[int, ...]:
    """Rule 3: the other robots that stand nearer to the front of those who stayed than to their end."""
    first, last = places[stayed[0]], places[stayed[-1]]

    def is_in_front(pose: Pose) -> bool:
        if len(stayed) > 1:
            return apart_m(pose, first) < apart_m(pose, last)
        return goal is not None and apart_m(pose, goal) < apart_m(first, goal)

    front = {robot: pose for robot, pose in places.items() if robot not in stayed and is_in_front(pose)}
    return chain({**front, stayed[0]: first}, stayed[0])[:0:-1]


def kept_order(places: Places, stayed: Sequence[int], front: Sequence[int]) -> tuple[int, ...]:
    """Rule 3: those in front, those who stayed, and the others behind them."""
    back = {robot: pose for robot, pose in places.items() if robot not in {*stayed[:-1], *front}}
    return (*front, *stayed[:-1], *chain(back, stayed[-1]))


def other_order(places: Places, led: Sequence[int], goal: Point | None) -> tuple[int, ...]:
    """Rule 4."""
    waiting = {robot: pose for robot, pose in places.items() if robot not in led}
    first = nearest_to(goal, waiting) if waiting else next(robot for robot in led if robot in places)
    return chain(places, first)
