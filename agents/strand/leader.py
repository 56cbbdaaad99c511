"""The leader: stands at a switching position, senses, and plans the next switching step.

Rule 1: one scan a switching position, one step a scan. Where no certified step comes nearer to the goal the
        leader looks closer once, with more revolutions of the scanner. A spot that is refused even then is
        closed, and what is left is ranked anew.
Rule 2: under the certified law no step is planned nearer than the strand's distance to ground that has
        been granted to robots behind. (The paper's laws know nothing of robots behind.)
Rule 3: where only the strand itself is in the way, the leader waits until it has closed up, and else has it
        turn round (`DeadEnd`).
Rule 4: a way that is not there is said (`NoStep`), never searched for by wandering. Who plans from one place
        again and again wanders, whatever each step promises; by the certified law, where nothing moves.
Rule 5: where bodies may have moved, and no way is left, the map begins anew, once an epoch.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from agents.navigation.certificate import Walls, bounds_walls, promised_clearance_m, scan_walls
from agents.navigation.ground import Ground
from agents.navigation.guidance import CostToGo, Map
from agents.navigation.scan import View, on_ground
from agents.navigation.step import (
    Crossed,
    NoStep,
    Sight,
    Step,
    certified_step_onward,
    certified_step_to,
    certified_step_to_goal,
    has_way,
    look,
    paper_step,
    refused_at,
)
from agents.strand.dead_end import way_back_m
from protocol.arrays import Flags, Floats
from protocol.frames import Point, Pose
from protocol.mission import Law, Mission
from protocol.timeline import SeenGap, SeenObstacle, StepPlanned
from protocol.wire.messages import RAYS_MAX

SEEN_MAX = 250  # obstacles and gaps in a timeline entry, which has to fit into one message
GAIN_M = 0.01  # a step that saves less of the way is not worth a stop
CLOSER = 4  # times the revolutions of the scanner: an obstacle's unseen part is a quarter
WAY_CELLS = 4000  # more than any way that a scan shows part of
ROOM_STEPS_MAX = 5  # round a hairpin some steps free no ground behind; to and fro in one place none does
AGAIN_CELLS = 2.0  # of the map: so near is the same place
AGAIN_MAX = 12  # ten steps of `GAIN_M` lead out of it; honest leaders come to one place 4 times at the most
SPOTS_MAX = 100  # closed from one place: a way that the certificate refuses so often is none


@dataclass(frozen=True)
class LookCloser:
    """Nothing can be said with so few rays."""


@dataclass(frozen=True)
class Wait:
    """The strand behind is in the way, and has not closed up yet."""


@dataclass(frozen=True)
class DeadEnd:
    """The only way on is back."""

    back_to_m: float
    """Arc length of the place from which the leader can go another way; 0: the tail had better lead."""


Plan = StepPlanned | NoStep | Crossed | LookCloser | Wait | DeadEnd


class Leader:
    """What the leader remembers from step to step."""

    def __init__(self, mission: Mission, start: Pose) -> None:
        self._mission = mission
        self._onward_rad = start.heading_rad
        self._goal = None if mission.goal is None else _xy(mission.goal)
        self.map = Map(mission, np.array([start.x_m, start.y_m]))
        self.steps = 0
        """Switching steps planned so far."""
        self._planned_in = 0
        self._planned_at: list[Floats] = []
        """From where steps have been planned, in that epoch."""
        self._forgot = False
        """Whether it has begun its map anew, in that epoch."""
        self._room: tuple[int, float] = (0, 0.0)
        """In which epoch, and up to where ground had been granted, when a step last made room."""
        self._room_steps = 0
        """Steps planned since then to make more."""
        self.bodies_may_move = False
        """Whether what stands in the way may be a robot that comes back."""

    @property
    def closer(self) -> int:
        """Revolutions of the scanner for a closer look."""
        return min(CLOSER * self._mission.revolutions, RAYS_MAX // self._mission.directions)

    def is_done(self, position: Floats) -> bool:
        """Whether this is the last switching position: the goal's, or the last that was asked for."""
        if self._goal is not None:
            return float(np.hypot(*(self._goal - position))) <= self._mission.goal_tolerance_m
        return self.steps + 1 == self._mission.switching_positions_max

    def plan(self, view: View, ground: Ground, *, epoch: int, settled: bool) -> Plan:
        """The next switching step out of a scan, as it goes into the timeline; or why there is none.

        Args:
            view: the scan.
            ground: what robots behind take up.
            epoch: the strand's.
            settled: whether the robots behind have come as near as they will.
        """
        if self._planned_in != epoch:
            self._planned_in, self._planned_at, self._forgot = epoch, [], False
        off_path_m = np.hypot(*(view.position - _path_end(ground)))
        lawful = off_path_m <= self._mission.mu0_m or not self._mission.law.promises_clearance
        assert lawful, f"planned {off_path_m} m from where the path ends"
        sight, hull_reach_m = look(view, self._mission), self._mission.hull_reach_m
        walls = Walls.joined(scan_walls(view, self._mission), ground.walls, *self._bounds())
        robots = on_ground(view.points, ground.occupied, within_m=hull_reach_m)
        if self._mission.law is not Law.CERTIFIED:
            step: Step | Plan = paper_step(sight, self._mission, gain_m=GAIN_M)
        elif self._goal is None:
            step = certified_step_onward(sight, walls, onward_rad=self._onward_rad, gain_m=GAIN_M)
        else:
            step = self._step_to(self._goal, view.without(robots), walls, ground, settled=settled)
        if not isinstance(step, Step):
            return step
        if self._wanders(view.position):
            return self._no_way("every step from here has led back here")
        self.steps += 1
        behind = on_ground(view.points, ground.behind, within_m=hull_reach_m)
        return self._record(step, sight, ground, behind, epoch)

    def _wanders(self, here: Floats) -> bool:
        """Rule 4; asked means that a step is planned from here, if not."""
        near_m = AGAIN_CELLS * self.map.cell_m
        again = sum(math.dist(here, place) <= near_m for place in self._planned_at)
        if again >= AGAIN_MAX and self._mission.law is Law.CERTIFIED and not self._mission.obstacles_move:
            return True
        self._planned_at.append(here)
        return False

    def make_room(self, view: View, ground: Ground, *, epoch: int, room_m: float) -> StepPlanned | NoStep:
        """The next step away, so that the robots behind can come so much further; along the shortest way.

        Steps after which no more could be granted to them make no room: after so many there is none.
        """
        if self._room[0] != epoch or ground.granted_m > self._room[1]:
            self._room, self._room_steps = (epoch, ground.granted_m), 0
        sight = look(view, self._mission)
        walls = Walls.joined(scan_walls(view, self._mission), ground.walls, *self._bounds())
        keep_m, cell_m = self._mission.robot_keep_m, self.map.cell_m
        off_here = self.map.cost_to_go(view.position, tolerance_m=cell_m, taken=ground.taken, keep_m=keep_m)
        place = off_here.place_at(room_m)
        step = None
        if place is not None:
            off_place = self.map.cost_to_go(place, tolerance_m=cell_m, taken=ground.taken, keep_m=keep_m)
            step = certified_step_to_goal(view, walls, off_place, gain_m=GAIN_M)
        if step is None or self._room_steps == ROOM_STEPS_MAX:
            return NoStep("both ends of the strand are in dead ends, and neither can make room for the other")
        self.steps += 1
        self._room_steps += 1
        behind = on_ground(view.points, ground.behind, within_m=self._mission.hull_reach_m)
        return self._record(replace(step, cost_to_go_m=None), sight, ground, behind, epoch)

    def _bounds(self) -> list[Walls]:
        bounds = self._mission.bounds
        return [] if bounds is None else [bounds_walls(bounds, self._mission)]

    def _step_to(
        self, goal: Floats, view: View, walls: Walls, ground: Ground, *, settled: bool
    ) -> Step | NoStep | LookCloser | Wait | DeadEnd:
        if self._world_changes:
            self.map.forget_where_free(view)
        self.map.remember(view.hit_points)
        step = certified_step_to(view, walls, goal)
        for _ in range(SPOTS_MAX):
            if step is not None:
                return step
            cost_to_go = self._cost_to_go(goal, ground.taken, origin=view.position)
            step = certified_step_to_goal(view, walls, cost_to_go, gain_m=GAIN_M)
            if step is not None:
                return step
            if not has_way(view, walls, cost_to_go):
                return self._turn_back(goal, view, ground, settled=settled)
            if len(view.ranges_m) < self._mission.directions * self.closer:
                return LookCloser()
            self._close(view, walls, cost_to_go)
        return self._no_way("no certified step comes nearer to the goal")

    def _cost_to_go(self, goal: Floats, taken: Floats, *, origin: Floats | None = None) -> CostToGo:
        tolerance_m, keep_m = self._mission.goal_tolerance_m, self._mission.robot_keep_m
        return self.map.cost_to_go(goal, tolerance_m=tolerance_m, taken=taken, keep_m=keep_m, origin=origin)

    def _close(self, view: View, walls: Walls, cost_to_go: CostToGo) -> None:
        """Close the narrowest spot of the way where the certificate refuses it: for robots, for now."""
        way = cost_to_go.way_from(view.position, cells_max=WAY_CELLS)
        refused = refused_at(view, walls, way)
        first = min(refused, len(way) - 1)
        off_first_m = np.hypot(*(way[first:] - way[first]).T)
        spot = self.map.narrowest(way[first:][off_first_m <= 2.0 * self._mission.obstacle_keep_m])
        robots = ~view.hits & (view.ranges_m < self._mission.range_m_max)
        alone = Walls.joined(scan_walls(view, self._mission, leave_out=robots), *self._bounds())
        still = not self._world_changes
        self.map.close(spot, for_good=still and refused_at(view, alone, way) <= refused)

    def _turn_back(
        self, goal: Floats, view: View, ground: Ground, *, settled: bool
    ) -> NoStep | Wait | DeadEnd:
        """What to do where no way leads past the strand."""

        def reachable(place: Floats, taken: Floats) -> bool:
            return bool(np.isfinite(self._cost_to_go(goal, taken).at(place[None])[0]))

        alone = Walls.joined(scan_walls(view, self._mission), *self._bounds())
        cost_to_go = self._cost_to_go(goal, np.empty((0, 2)))
        # What the leader has come along it can go back along, though hulls may stand all around it now.
        come_m = cost_to_go.at(ground.path.between(0.0, ground.path.end_m))
        if not len(ground.taken) or not (has_way(view, alone, cost_to_go) or np.isfinite(come_m).any()):
            return self._no_way("no way to the goal is left in what is known")
        if not settled:
            return Wait()
        back_to_m = way_back_m(ground, self._mission.obstacle_keep_m, reachable)
        return DeadEnd(0.0 if back_to_m is None else back_to_m)

    def _no_way(self, reason: str) -> NoStep:
        """There is none left. Where obstacles move, what has been refused may be free at the next look.

        Not before: a spot that is open again with every scan is gone to, and refused, for ever.
        What bodies that have moved on leave in the map may stay in the shadow of others (rule 5).
        """
        if self._world_changes:
            self.map.reopen()
        if self.bodies_may_move and not self._forgot:
            self._forgot = True
            self.map.forget()
        return NoStep(reason)

    @property
    def _world_changes(self) -> bool:
        return self._mission.obstacles_move or self.bodies_may_move

    def _record(self, step: Step, sight: Sight, ground: Ground, behind: Flags, epoch: int) -> StepPlanned:
        target = step.target(sight.view.position)
        passable = set(sight.passable_gaps)
        promised_m = None
        if self._mission.law.promises_clearance:
            promised_m = promised_clearance_m(sight.view, target, behind, self._mission)
        return StepPlanned(
            step=self.steps,
            epoch=epoch,
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
            reach_m=ground.path.end_m + float(np.hypot(*(target - _path_end(ground)))),
            promised_clearance_m=promised_m,
            cost_to_go_m=step.cost_to_go_m,
        )


def _path_end(ground: Ground) -> Floats:
    end = ground.path.at(ground.path.end_m)
    return np.array([end.x_m, end.y_m])


def point(xy: Floats) -> Point:
    """A point of plain floats, as the wire wants it."""
    return Point(x_m=float(xy[0]), y_m=float(xy[1]))


def _xy(at: Point) -> Floats:
    return np.array([at.x_m, at.y_m])
