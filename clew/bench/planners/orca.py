"""ORCA, optimal reciprocal collision avoidance (van den Berg, Guy, Lin and Manocha, 2011), for comparison.

It is that of pyrvo, which wraps the authors' library RVO2: the extra `peers`. Each scan gives the velocity
for the next period: of those that meet no obstacle within the horizon, the one nearest to that towards the
goal. It remembers nothing and certifies nothing.

Rule 1: obstacles are the lines through neighbouring hits, simplified by no more than the tolerance: the time
        that RVO2 takes grows with the square of the number of segments.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pyrvo
import shapely

from agents.navigation.obstacles import passable_width_m
from agents.navigation.scan import View
from protocol.arrays import Floats
from protocol.mission import Mission

PERIOD_S = 0.1  # between two plans
AHEAD_S = 1.7  # as far as the dynamic window looks
NEIGHBOURS_MAX = 10  # other robots; there are none


class Orca:
    """The planner, for a mission with a goal."""

    def __init__(self, mission: Mission) -> None:
        assert mission.goal is not None, "the caller has checked"
        self._goal = np.array([mission.goal.x_m, mission.goal.y_m])
        self._mission = mission

    def plan(self, view: View) -> float:
        """Choose the velocity; returns how far the robot drives until the next plan [m]."""
        mission = self._mission
        sizes = mission.range_m_max, NEIGHBOURS_MAX, AHEAD_S, AHEAD_S
        simulator = pyrvo.RVOSimulator(PERIOD_S, *sizes, mission.obstacle_keep_m, mission.speed_mps)
        robot = simulator.add_agent(tuple(view.position.tolist()))
        for line in _lines(view, passable_width_m(mission.obstacle_keep_m)):
            corners = shapely.get_coordinates(shapely.simplify(shapely.LineString(line), mission.mu0_m))
            places = list(map(tuple, corners.tolist()))
            for segment in pairwise(places):
                simulator.add_obstacle(list(segment))
        simulator.process_obstacles()
        off = self._goal - view.position
        wanted = off * min(mission.speed_mps / float(np.hypot(*off)), 1.0 / PERIOD_S)
        simulator.set_agent_pref_velocity(robot, tuple(wanted.tolist()))
        simulator.do_step()
        velocity = simulator.get_agent_velocity(robot)
        return float(np.hypot(velocity.x, velocity.y)) * PERIOD_S


def _lines(view: View, passable_m: float) -> Iterator[Floats]:
    """The runs of neighbouring hits (n, 2) that nothing passes between, with two hits or more."""
    apart_m = np.hypot(*(np.roll(view.points, -1, axis=0) - view.points).T)
    is_last = ~(view.hits & np.roll(view.hits, -1) & (apart_m < passable_m))
    first = int(np.argmax(is_last)) + 1  # so that no run goes across the ends of the array
    points, is_last = np.roll(view.points, -first, axis=0), np.roll(is_last, -first)
    for run in np.split(points, np.flatnonzero(is_last) + 1):
        if len(run) > 1:
            yield run
