"""The leader: stands at a switching position, senses, and plans the next switching step.

Rule 1: one scan a switching position, one step a scan.
Rule 2: under the certified law no step is planned nearer than the strand's distance to ground that has
        been granted to robots behind. (The paper's laws know nothing of robots behind.)
Rule 3: a way that is not there is said (`NoStep`), never searched for by wandering.
"""

import numpy as np

from agents.certificate import Walls, bounds_walls, promised_clearance_m, scan_walls
from agents.ground import Ground
from agents.guidance import Map
from agents.scan import View, on_ground
from agents.step import (
    Crossed,
    NoStep,
    Sight,
    Step,
    certified_step_onward,
    certified_step_to_goal,
    look,
    paper_step,
)
from protocol.arrays import Flags, Floats
from protocol.frames import Point, Pose
from protocol.mission import Bounds, Law, Mission
from protocol.timeline import SeenGap, SeenObstacle, StepPlanned

CELL_M_MAX = 0.05  # 9 ms for the cost-to-go of 27,000 cells, measured on two shared cores
CELLS_A_BERTH = 4.0  # so that the shape of a gap survives
SEEN_MAX = 250  # obstacles and gaps in a timeline entry, which has to fit into one message
GAIN_M = 0.01  # a step that saves less of the way is not worth a stop


class Leader:
    """What the leader remembers from step to step."""

    def __init__(self, mission: Mission, start: Pose) -> None:
        self._mission = mission
        self._onward_rad = start.heading_rad
        self._goal = None if mission.goal is None else _xy(mission.goal)
        bounds = mission.bounds or _around(start, mission)
        self._map = Map(bounds, cell_m=min(CELL_M_MAX, mission.berth_m / CELLS_A_BERTH))
        self.steps = 0
        """Switching steps planned so far."""

    def is_done(self, position: Floats) -> bool:
        """Whether this is the last switching position: the goal's, or the last that was asked for."""
        if self._goal is not None:
            return float(np.hypot(*(self._goal - position))) <= self._mission.goal_tolerance_m
        return self.steps + 1 == self._mission.switching_positions_max

    def plan(self, view: View, ground: Ground) -> StepPlanned | NoStep | Crossed:
        """The next switching step out of a scan, as it goes into the timeline."""
        off_path_m = np.hypot(*(view.position - ground.path.between(0.0, ground.path.end_m)[-1]))
        lawful = off_path_m <= self._mission.mu0_m or not self._mission.law.promises_clearance
        assert lawful, f"planned {off_path_m} m from where the path ends"
        sight, hull_reach_m = look(view, self._mission), self._mission.hull_reach_m
        walls = Walls.joined(scan_walls(view, self._mission), ground.walls, *self._bounds())
        step = self._step(sight, walls, on_ground(view.points, ground.occupied, within_m=hull_reach_m))
        if not isinstance(step, Step):
            return step
        self.steps += 1
        behind = on_ground(view.points, ground.behind, within_m=hull_reach_m)
        return self._record(step, sight, ground, behind)

    def _bounds(self) -> list[Walls]:
        bounds = self._mission.bounds
        return [] if bounds is None else [bounds_walls(bounds, self._mission)]

    def _step(self, sight: Sight, walls: Walls, robots: Flags) -> Step | NoStep | Crossed:
        if self._mission.law is not Law.CERTIFIED:
            return paper_step(sight, self._mission, gain_m=GAIN_M)
        if self._goal is None:
            return certified_step_onward(sight, walls, onward_rad=self._onward_rad, gain_m=GAIN_M)
        self._map.remember(sight.view.without(robots).hit_points)
        cost_to_go = self._map.cost_to_go(
            self._goal,
            tolerance_m=self._mission.goal_tolerance_m,
            keep_m=self._mission.berth_m,
            keep_in_m=self._mission.robot_radius_m + self._mission.mu0_m,
        )
        return certified_step_to_goal(sight.view, walls, cost_to_go, self._goal, gain_m=GAIN_M)

    def _record(self, step: Step, sight: Sight, ground: Ground, behind: Flags) -> StepPlanned:
        target = step.target(sight.view.position)
        passable = set(sight.passable_gaps)
        promised_m = None
        if self._mission.law.promises_clearance:
            promised_m = promised_clearance_m(sight.view, target, behind, self._mission)
        return StepPlanned(
            step=self.steps,
            law=self._mission.law,
            x_m=float(sight.view.position[0]),
            y_m=float(sight.view.position[1]),
            obstacles=tuple(
                SeenObstacle(
                    tangent_1=point(obstacle.tangent_1),
                    tangent_2=point(obstacle.tangent_2),
                    chord_m=obstacle.chord_m,
                )
                for obstacle in sight.obstacles[:SEEN_MAX]
            ),
            gaps=tuple(
                SeenGap(
                    right=gap.right,
                    left=gap.left,
                    width_m=gap.width_m,
                    delta_rad=gap.delta_rad,
                    passable=index in passable,
                )
                for index, gap in enumerate(sight.gaps[:SEEN_MAX])
            ),
            gap=step.gap if step.gap is not None and step.gap < SEEN_MAX else None,
            heading_rad=step.heading_rad,
            length_m=step.length_m,
            target=point(target),
            reach_m=ground.path.end_m + step.length_m,
            promised_clearance_m=promised_m,
            cost_to_go_m=step.cost_to_go_m,
        )


def point(xy: Floats) -> Point:
    """A point of plain floats, as the wire wants it."""
    return Point(x_m=float(xy[0]), y_m=float(xy[1]))


def _xy(at: Point) -> Floats:
    return np.array([at.x_m, at.y_m])


def _around(start: Pose, mission: Mission) -> Bounds:
    """Where the region has no bounds: the box of start and goal, with the sensor's range on all sides."""
    ends: list[Pose | Point] = [start, mission.goal or start]
    margin_m = mission.range_m_max
    return Bounds(
        x_m_min=min(end.x_m for end in ends) - margin_m,
        y_m_min=min(end.y_m for end in ends) - margin_m,
        x_m_max=max(end.x_m for end in ends) + margin_m,
        y_m_max=max(end.y_m for end in ends) + margin_m,
    )
