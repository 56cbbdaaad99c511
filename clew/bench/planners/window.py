"""The dynamic-window approach (Fox, Burgard and Thrun, 1997), for comparison.

Each scan gives the velocities for the next period: of all pairs of speed and turn rate whose arc stays clear,
the one with the best sum of heading, clearance and speed. It remembers nothing and certifies nothing.
It is ours because nothing maintained on PyPI has it: the one package there has no wheel, and does not build.

Rule 1: bodies of ours reach their speeds at once, so the window is all velocities, forwards.
Rule 2: it looks at the goal when it begins: a scan does not tell where the body looks.
"""

import numpy as np
from scipy.spatial import KDTree

from agents.navigation.scan import View
from protocol.arrays import Floats, unit_vectors
from protocol.mission import Mission

SAMPLES = 20  # of speed and of turn rate each; these three are what Nav2's DWB has by default
AHEAD_S = 1.7
STEPS = 17
PERIOD_S = 0.1  # between two plans
TURN_RADPS = np.pi / 2.0  # as the bodies of our scenarios
HEADING, CLEARANCE, SPEED = 2.0, 0.2, 0.2  # the paper's weights of what is best


class Window:
    """The planner, for a mission with a goal."""

    def __init__(self, mission: Mission) -> None:
        assert mission.goal is not None, "the caller has checked"
        self._goal = np.array([mission.goal.x_m, mission.goal.y_m])
        self._keep_m, self._range_m = mission.obstacle_keep_m, mission.range_m_max
        speeds = np.linspace(0.0, mission.speed_mps, SAMPLES)
        turns = np.linspace(-TURN_RADPS, TURN_RADPS, SAMPLES)  # an even number of them: none is 0
        self._speed, self._turn = (each.ravel() for each in np.meshgrid(speeds, turns))
        since_s = np.linspace(AHEAD_S / STEPS, AHEAD_S, STEPS)
        self._turned_rad = self._turn[:, None] * since_s
        radius_m = (self._speed / self._turn)[:, None]
        self._ahead_m = radius_m * np.sin(self._turned_rad)
        self._beside_m = radius_m * (1.0 - np.cos(self._turned_rad))

    def plan(self, view: View) -> float:
        """Choose the velocities; returns how far the robot drives until the next plan [m]."""
        off = self._goal - view.position
        goal_rad, goal_m = float(np.arctan2(off[1], off[0])), float(np.hypot(*off))
        ahead, left = unit_vectors(np.array([goal_rad, goal_rad + np.pi / 2.0]))
        places = view.position + self._ahead_m[..., None] * ahead + self._beside_m[..., None] * left
        clear_m = self._clear_m(places, view.hit_points)
        left_rad = np.arctan2(*(self._goal - places[:, -1]).T[::-1]) - goal_rad - self._turned_rad[:, -1]
        off_rad = np.abs((left_rad + np.pi) % (2.0 * np.pi) - np.pi)
        worth = HEADING * (1.0 - off_rad / np.pi) + CLEARANCE * clear_m / self._range_m
        worth += SPEED * self._speed / self._speed.max()
        best = int(np.argmax(np.where(clear_m > 0.0, worth, -np.inf)))
        return min(float(self._speed[best]) * PERIOD_S, goal_m) if clear_m[best] > 0.0 else 0.0

    def _clear_m(self, places: Floats, hits: Floats) -> Floats:
        """The least distance beyond the one to keep along each arc (v, steps, 2); at most the range."""
        if len(hits) == 0:
            return np.full(len(places), self._range_m)
        off_m, _ = KDTree(hits).query(places.reshape(-1, 2), distance_upper_bound=self._range_m)
        least_m = np.minimum(off_m, self._range_m).reshape(len(places), -1).min(axis=1)
        return np.asarray(least_m - self._keep_m)
