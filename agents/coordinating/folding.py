"""Whether a strand that forms through the places of its robots folds back on itself. Pure.

Rule 1 (safety): two legs that are not neighbours keep the least distance from each other, and so does each
        end of the strand from all legs but its own. Otherwise ground that robots behind may be on would be
        too near, from the start, to ground that the robots ahead still have to drive: a robot that already
        is too near to a segment of such ground may drive along it (`protocol.sweep`), towards a robot there.
Rule 2: where all legs were driven, the strand may come nearer by the tolerance, as its robots did in the
        strands that drove them (`protocol.wire.authority`). Legs of several strands may do worse: each was
        laid while other robots were left out, perhaps through where one of these stands now.
"""

from bisect import bisect_left
from collections.abc import Mapping, Sequence

import numpy as np

from agents.coordinating.order import Places, positions
from protocol.arrays import Floats, Indices, distances_to_segments, places_xy, segments_apart
from protocol.frames import Point, Pose
from protocol.mission import Mission

Legs = Mapping[int, Sequence[Point]]
"""A robot's driven way to the one ahead, ends included; without an entry it goes straight.

It ends beside where bodies stand, by what their drives were off.
"""


def line_of(places: Places, order: Sequence[int], legs: Legs) -> tuple[Floats, Indices]:
    """The way from the first of an order to its last (n, 2), and which leg each segment is of (n - 1,)."""
    corners: list[Point | Pose] = [places[order[0]]]
    leg: list[int] = []
    for index, robot in enumerate(order[1:]):
        corners += [*reversed(legs.get(robot, ())[1:-1]), places[robot]]
        leg += [index] * (len(corners) - 1 - len(leg))
    return places_xy(corners), np.array(leg, dtype=np.intp)


def folds_back(places: Places, order: Sequence[int], legs: Legs, *, least_m: float) -> bool:
    """Rule 1: whether the strand in this order folds back."""
    if len(order) < 2:
        return False
    line, leg = line_of(places, order, legs)
    starts, ends = line[:-1], line[1:]
    near_m = segments_apart(starts[:, None], ends[:, None], starts[None], ends[None])
    apart = [
        np.hypot(*np.diff(positions(places, order), axis=0).T),
        near_m[leg[None] - leg[:, None] >= 2],
        distances_to_segments(line[0], starts[leg >= 1], ends[leg >= 1]),
        distances_to_segments(line[-1], starts[leg < leg[-1]], ends[leg < leg[-1]]),
    ]
    return bool(np.concatenate(apart).min() < least_m)


def robots_in_place(places: Places, order: Sequence[int], legs: Legs, mission: Mission) -> int:
    """How many robots of an order, from the front on, make a strand that does not fold back (rule 2)."""
    keep_m = mission.robot_keep_m
    stays = next((rank for rank, robot in enumerate(order) if rank > 0 and robot not in legs), len(order))
    return max(
        robots_apart(places, order, legs, least_m=keep_m),
        robots_apart(places, order[:stays], legs, least_m=keep_m - mission.mu0_m),
    )


def robots_apart(places: Places, order: Sequence[int], legs: Legs, *, least_m: float) -> int:
    """How many robots of an order, from the front on, make a strand that does not fold back.

    A strand that folds back does so however many join it, so this is found by halves.
    """
    if not folds_back(places, order, legs, least_m=least_m):
        return len(order)
    counts = range(1, len(order))
    return 1 + bisect_left(
        counts, True, key=lambda count: folds_back(places, order[: count + 1], legs, least_m=least_m)
    )
