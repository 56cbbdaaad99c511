"""One robot's part in the lining up: what it announces, and when it may take its place.

Rule 1: it announces itself on every change and on every heartbeat, until it has its place; so any
        announcement may be lost.
Rule 2: it senses only where the order depends on it: without a goal, once all places are known.
"""

import numpy as np

from agents.commands import Announce, Command
from agents.muster import Roster, folds_back
from agents.scan import View, on_discs
from protocol.frames import Pose
from protocol.messages import Muster
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


class Lining:
    """What one robot knows and says while the strand forms."""

    def __init__(self, robot: int, mission: Mission) -> None:
        self._robot = robot
        self._mission = mission
        self._roster = Roster(mission.robots, mission.goal)
        self._obstacle_m: float | None = None
        self._announced: Muster | None = None
        self._announced_at_s = -float("inf")

    @property
    def places(self) -> dict[int, Pose]:
        """Where all robots stand."""
        places = self._roster.places
        assert places is not None, "nobody takes a place before all are known"
        return places

    @property
    def order(self) -> tuple[int, ...]:
        """The strand, leader first; empty until it can be known."""
        return self._roster.order()

    @property
    def wants_scan(self) -> bool:
        """Rule 2."""
        return self._mission.goal is None and self._roster.places is not None and self._obstacle_m is None

    @property
    def sensed(self) -> bool:
        """Whether a scan has been taken."""
        return self._obstacle_m is not None

    @property
    def may_lead(self) -> bool:
        """Whether this robot leads and all have confirmed the order."""
        return self.order[:1] == (self._robot,) and self._roster.agreed()

    @property
    def folds_back(self) -> bool:
        """Whether robots stand so that no strand can be drawn through their places."""
        least_m = 2.0 * self._mission.robot_radius_m + self._mission.separation_m - TOUCHING_M
        return folds_back(self.places, self.order, least_m=least_m)

    def hear(self, robot: int, muster: Muster) -> None:
        """Take in what another robot announces."""
        if robot != self._robot:
            self._roster.hear(robot, muster)

    def announce(self, pose: Pose, scan: View | None, now_s: float) -> list[Command]:
        """Rule 1, with what a scan adds."""
        self._roster.hear(self._robot, Muster(pose=pose, obstacle_m=self._obstacle_m, order=()))
        if scan is not None and self.wants_scan:
            self._obstacle_m = self._nearest_obstacle_m(scan)
            self._roster.hear(self._robot, Muster(pose=pose, obstacle_m=self._obstacle_m, order=()))
        muster = Muster(pose=pose, obstacle_m=self._obstacle_m, order=self.order)
        self._roster.hear(self._robot, muster)
        if muster == self._announced and now_s - self._announced_at_s < self._mission.heartbeat_s:
            return []
        self._announced, self._announced_at_s = muster, now_s
        return [Announce(muster)]

    def _nearest_obstacle_m(self, scan: View) -> float:
        """(3): distance to the nearest hit that is no robot; the range limit where there is none."""
        others = [(pose.x_m, pose.y_m) for robot, pose in self.places.items() if robot != self._robot]
        hulls = on_discs(scan.points, np.array(others).reshape(-1, 2), within_m=self._mission.hull_reach_m)
        nearest_m = scan.without(hulls).nearest_m
        return self._mission.range_m_max if nearest_m is None else nearest_m
