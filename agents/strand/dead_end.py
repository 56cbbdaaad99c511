"""The way out of a dead end: how far the strand has to back up, and how a leader makes room for that. Pure.

Rule 1: if the leader has another way from a place between it and the tail, past the robots behind, the strand
        backs up along its own path until it stands there, as a train does. The robots behind will take up as
        much of the path as they do now.
Rule 2: if it has none, no robot ahead of the tail leads out: the tail leads, from where it stands, and need
        not take again each turn that the strand has taken. If the map shows no way from there, as in a
        corridor that barely fits, the strand backs up to where it shows one. It also does after an attempt
        in vain: the map may show the tail a way that it has already been refused.
Rule 3: where the tail cannot come back far enough, its leader steps away on the shortest way that lets it.
Rule 4: a step after which no more can be granted makes no room. After `ROOM_STEPS_MAX` of them it gives up.
Rule 5: a strand that backs up takes along only as much of the path as its leader needs. A robot grants no
        ground beside path that it may still drive. So where a path crosses itself, robots that can go back
        all the way pass the loop one at a time.
"""

from collections.abc import Callable

import numpy as np

from agents.navigation.certificate import Walls
from agents.navigation.ground import Ground
from agents.navigation.guidance import Map
from agents.navigation.scan import View
from agents.navigation.step import Step, certified_step_to_goal
from agents.strand.grants import GRANT_M_MIN
from protocol.arrays import Floats, xy
from protocol.mission import Mission
from protocol.path import Path
from protocol.wire.authority import authority_m

PLACES_APART_KEEPS = 1.0  # how fine the path is searched, in least distances of a centre
ROOM_STEPS_MAX = 5  # some steps round a hairpin free no ground behind; steps to and fro never do


def way_back_m(
    ground: Ground, keep_m: float, reachable: Callable[[Floats, Floats], bool], *, tail_may_lead: bool
) -> float | None:
    """An arc length from which the leader has another way (rule 1); None: the tail leads (rule 2).

    It is one place short of the farthest, from where the certificate may refuse what the map shows.

    Backing up only frees ground in front, so from every place before it the goal can be reached too.

    Args:
        ground: the strand behind the leader, which stands at the path's end.
        keep_m: least distance of a centre from an obstacle.
        reachable: whether the goal can be reached from a place (2,), with so much ground taken (n, 2).
        tail_may_lead: whether the strand has made no attempt in vain since it last advanced.
    """
    path, tail_m, end_m = ground.path, ground.tail_m, ground.path.end_m
    places_m = np.append(np.arange(0.0, end_m, PLACES_APART_KEEPS * keep_m), end_m)

    def reaches(index: int) -> bool:
        return reachable(xy(path.at(places_m[index])), ground.taken_from(places_m[index]))

    good, bad = -1, len(places_m) - 1
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if reaches(middle) else (good, middle)
    back_to_m = float(places_m[max(good - 1, 0)])
    if tail_may_lead and back_to_m <= tail_m and reachable(xy(path.at(tail_m)), ground.taken_from_tail):
        return None
    return back_to_m


def cut_before_m(path: Path, mission: Mission, *, robots: int, tail_m: float, back_by_m: float) -> float:
    """The arc length before which a strand that backs up needs none of its path (rule 5).

    Args:
        path: the path, at whose end the leader stands.
        mission: what the robots have to keep.
        robots: how many there are in the strand.
        tail_m: arc length of the tail.
        back_by_m: how far the leader is to come back.
    """
    spare_m = robots * GRANT_M_MIN  # a robot is granted up to so much less than is free
    while (cut_m := tail_m - back_by_m - spare_m) > 0.0:
        if _last_grant_m(path.reversed(cut_m, path.end_m), mission, robots) >= back_by_m:
            return cut_m
        spare_m *= 2.0
    return 0.0


def _last_grant_m(back: Path, mission: Mission, robots: int) -> float:
    """How far the last robot may come along this path when the first has come to its end."""
    at_m = back.end_m
    for behind in reversed(range(robots - 1)):
        from_m = behind * 2.0 * mission.robot_radius_m  # it stands at least there: hulls do not overlap
        free_m = authority_m(back, from_m=from_m, progress_m=at_m, keep_m=mission.grant_keep_m)
        at_m = max(free_m - GRANT_M_MIN, 0.0)
    return at_m


class Room:
    """The steps of one leader that were to make room for a tail that wants to come back."""

    def __init__(self, mission: Mission) -> None:
        self._keep_m = mission.robot_keep_m
        self._epoch, self._granted_m = 0, 0.0
        """When a step last made room."""
        self._steps = 0
        """Planned since then."""

    def step(
        self, known: Map, view: View, walls: Walls, ground: Ground, *, epoch: int, room_m: float
    ) -> Step | None:
        """A step after which the robots behind can drive `room_m` further; None: there is none."""
        if self._epoch != epoch or ground.granted_m > self._granted_m:
            self._epoch, self._granted_m, self._steps = epoch, ground.granted_m, 0
        taken, keep_m, cell_m = ground.taken, self._keep_m, known.cell_m
        off_here = known.cost_to_go(view.position, tolerance_m=cell_m, taken=taken, keep_m=keep_m)
        place = off_here.place_at(room_m)
        if place is None or self._steps == ROOM_STEPS_MAX:
            return None
        off_place = known.cost_to_go(place, tolerance_m=cell_m, taken=taken, keep_m=keep_m)
        step = certified_step_to_goal(view, walls, off_place)
        self._steps += step is not None
        return step
