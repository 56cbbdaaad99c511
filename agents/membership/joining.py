"""Joining the strand: switching steps of one robot, while all others stand, to a place at its end.

Rule 1: it is in place where it stands at least `keep` from all robots, the leg to the robot ahead is clear by
        its own scan and by the law of a robot's own leg, and the strand through it does not fold back.
Rule 2: until then it goes to the nearest such place, as far as it knows; unknown ground is free. Steps
        are certified as the leader's are; robots are obstacles, and the map does not keep them.
        A robot may stand nearer to something than a step may come, for example beside a robot that died in a
        queue. It may pass that at the distance that it has promised to keep and a little more.
        A spot that the closest look refuses is closed until the turn ends. Else the robot goes to and fro
        between two of them.
Rule 3: where obstacles move, a remembered hit is dropped when a scan shows free ground there, and a refused
        spot is closed in one plan only.
Rule 4: legs of the strand may be crossed on the way: nobody drives on them before all are in place.
Rule 5: a search ends when its way is twice as long as it first seemed. Other robots may have shorter ways; in
        its next turn the robot begins from what it knows by then. It ends, too, for one that creeps, or goes
        to and fro: however short a step is, it takes time.
"""

import math
from dataclasses import dataclass

import numpy as np

from agents.membership.legs import leg_is_clear, leg_needs_closer_look, without_hulls
from agents.membership.stands import HIT_M, Stands, outlines, places_behind
from agents.navigation.certificate import Walls, bounds_walls, scan_walls
from agents.navigation.guidance import Map, shown_free
from agents.navigation.record import planned
from agents.navigation.scan import View
from agents.navigation.step import (
    GAIN_M,
    LookCloser,
    NoStep,
    Step,
    certified_step_to,
    certified_step_to_goal,
    refused_at,
)
from agents.navigation.sure import closer
from protocol.arrays import Flags, Floats
from protocol.legs import PASSED_SHARE
from protocol.mission import Mission
from protocol.timeline import StepPlanned

LONGER = 2.0  # than a way first seemed: the way round what was not known then
STEP_SHARE = 0.25  # of the longest leg: a shorter step counts as that
SPOTS_MAX = 4  # spots of a way closed in one plan, where the certificate refuses what the grid shows
WAY_CELLS = 200  # of a way that is looked at: 10 m and more


@dataclass(frozen=True)
class InPlace:
    """The robot stands at a place."""


class Joining:
    """What a robot remembers from step to step while it joins, and from view to view."""

    _map: Map
    _hits: Floats

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._epoch = 0
        self._robots: tuple[int, ...] | None = None
        self._way_m = 0.0
        self._left_m = math.inf
        """How long the rest of this search may be (rule 5); without end: it has not begun."""
        self._steps = 0

    def begin(self, here: Floats, *, epoch: int, robots: tuple[int, ...]) -> None:
        """Begin a turn, beside these robots. Where nothing moves, only one that comes or goes is news."""
        self._epoch, self._left_m = epoch, math.inf
        if robots == self._robots and not self._mission.obstacles_move:
            self._map.reopen()
            return
        self._robots = robots
        self._map = Map(self._mission, here)
        self._hits = np.empty((0, 2))

    def release(self) -> None:
        """Give up the cells of the map until the next turn."""
        self._map.release()

    def plan(self, view: View, stands: Stands) -> StepPlanned | InPlace | NoStep | LookCloser:
        """What to do from here: rule 1, else rule 2."""
        here = view.position[None]
        admitted = bool(stands.admit(here, self._mission.robot_keep_m)[0])
        seen = without_hulls(view, stands.all, self._mission)
        if admitted and leg_is_clear(seen, stands.strand[-1], self._mission):
            return InPlace()
        if admitted and leg_needs_closer_look(seen, stands.strand[-1], self._mission):
            return LookCloser()
        if self._mission.obstacles_move:
            self._map.forget_where_free(view)
            self._hits = self._hits[~shown_free(self._hits, view, short_m=self._map.cell_m)]
        self._remember(seen.hit_points)
        step = self._step(view, stands)
        return self._record(step, view, view.hits & ~seen.hits) if isinstance(step, Step) else step

    def _remember(self, hit_points: Floats) -> None:
        self._map.remember(hit_points)
        known = np.concatenate([self._hits, np.round(hit_points / HIT_M) * HIT_M])
        self._hits = np.unique(known.view(np.complex128)).view(np.float64).reshape(-1, 2)

    def _step(self, view: View, stands: Stands) -> Step | NoStep | LookCloser:
        places = places_behind(stands, self._hits, self._mission)
        walls = self._walls(view, stands)
        # Where it stands it is not in place, whatever is remembered.
        places = places[np.hypot(*(places - view.position).T) > GAIN_M]
        ground = self._map.extended(outlines(stands.all, self._mission))
        keep_m = self._mission.obstacle_keep_m
        for _ in range(SPOTS_MAX):
            way_m = ground.cost_to_go(view.position, tolerance_m=keep_m).at(places)
            if not np.isfinite(way_m).any():
                break
            least_m = float(way_m.min())
            if math.isinf(self._left_m):
                self._left_m = LONGER * max(least_m, self._mission.leg_m_max)
            if least_m > self._left_m:
                return NoStep("the way to a place is much longer than it seemed")
            place = places[int(np.argmin(way_m))]
            cost_to_go = ground.cost_to_go(place, tolerance_m=keep_m)
            step = certified_step_to(view, walls, place)
            step = step or certified_step_to_goal(view, walls, cost_to_go)
            if step is not None:
                return step
            if closer(self._mission, len(view.ranges_m)) is not None:
                return LookCloser()
            way = cost_to_go.way_from(view.position, cells_max=WAY_CELLS)
            spot = way[min(refused_at(view, walls, way), len(way) - 1)] if len(way) else place
            ground.close(spot)
            if not self._mission.obstacles_move:
                self._map.close(spot, for_good=False)
        return NoStep("no way to a place at the strand's end is left in what is known")

    def _walls(self, view: View, stands: Stands) -> Walls:
        robots = stands.all
        discs = Walls(robots, robots, np.full(len(robots), self._mission.robot_keep_m))
        bounds = self._mission.bounds
        sides = [] if bounds is None else [bounds_walls(bounds, self._mission)]
        scan = scan_walls(view, self._mission)
        least_m = scan.keep_m - PASSED_SHARE * self._mission.mu0_m
        return Walls.joined(scan.eased(view.position, least_m), discs, *sides)

    def _record(self, step: Step, view: View, hulls: Flags) -> StepPlanned:
        self._steps += 1
        self._way_m += step.length_m
        self._left_m -= max(step.length_m, STEP_SHARE * self._mission.leg_m_max)
        return planned(
            step, view, hulls, self._mission, number=self._steps, epoch=self._epoch, reach_m=self._way_m
        )
