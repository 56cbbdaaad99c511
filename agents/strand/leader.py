"""The leader: senses at a switching position and plans the next switching step.

Rule 1: one scan per switching position, one step per scan. If no certified step comes nearer to the goal, the
        leader scans once more with more revolutions. A spot that is refused even then is closed in the map,
        and a law that uses the ways of the map is asked again.
Rule 2: steps keep the robots' distance from ground that has been granted to robots behind. (The paper's laws
        do not consider robots behind.)
Rule 3: if only the strand itself is in the way, the leader waits until the strand has closed up. If that does
        not help, the strand turns round (`DeadEnd`).
Rule 4: if there is no way, the leader reports it (`NoStep`) and does not wander in search of one. If no
        obstacle moves, planning from one place again and again counts as wandering (not by the paper's laws).
Rule 5: where bodies may have moved and no way is left, the map is cleared, once per epoch. Where only the
        leader has changed since another one found no way, it is not: both would hope for ever.
Rule 6: where obstacles move, a step keeps off all ground that they can reach while a motion has to be safe
        (`Mission.watch_s`). If that leaves no way past what stands, it plans a step that keeps off only what
        they can reach in one *moment* (docs/words.md): the body then drives by moments
        (`agents/body/watch.py`).
Rule 7: where nothing but the strand moves, scans of the same epoch from other places narrow what the closest
        look may have missed. In another epoch bodies may have moved (F6 of docs/strand.md). If no step is
        certified from the only place so far, a short one leads to another place.
Rule 8: in a sharp turn the way on may come a little nearer than robots keep to ground that is granted, which
        is never taken back. Then no spot of the map is to blame: the strand turns round, once, and the leader
        comes again. From then on robots behind leave free the way on that its map shows.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import msgspec
import numpy as np

from agents.navigation.certificate import Walls, bounds_walls, scan_walls, short_step_m, short_step_walls
from agents.navigation.ground import Ground
from agents.navigation.guidance import CostToGo, Map
from agents.navigation.law import Refused, Seen, Why, asked
from agents.navigation.record import planned
from agents.navigation.scan import View, on_ground
from agents.navigation.step import (
    Crossed,
    LookCloser,
    NoStep,
    Sight,
    Step,
    has_way,
    is_open,
    look,
    refused_at,
)
from agents.navigation.sure import closer
from agents.strand.dead_end import Room, way_back_m
from agents.strand.visited import Visited
from protocol.arrays import Floats, xy
from protocol.frames import COUNT_MAX, Pose
from protocol.laws import find
from protocol.mission import BRIEF_S, CERTIFIED, Mission
from protocol.sweep import Place
from protocol.timeline import StepPlanned

WAY_CELLS = 4000  # longer than any way of which a scan shows a part
ONWARD_KEEPS = 3.0  # so far from where they meet at 20 degrees, two ways are further apart than robots keep
AGAIN_CELLS = 2.0  # cells of the map: within this distance it is the same place
NO_WAY = NoStep("no way to the goal is left in what is known")
SPOTS_MAX = 100  # closed from one place: after so many refusals there is no way


@dataclass(frozen=True)
class Wait:
    """The strand behind is in the way and has not closed up yet."""


@dataclass(frozen=True)
class DeadEnd:
    """The only way leads back."""

    back_to_m: float | None
    """Arc length from which the leader has another way; None: the tail leads, at once."""


Plan = StepPlanned | NoStep | Crossed | LookCloser | Wait | DeadEnd


class Leader:
    """The state of the leader from step to step."""

    def __init__(self, mission: Mission, start: Pose) -> None:
        self._mission = mission
        self._onward_rad = start.heading_rad
        self._goal = None if mission.goal is None else xy(mission.goal)
        self.map = Map(mission, xy(start))
        self._steps = 0
        self._visited = Visited()
        self._forgot = False
        """Whether the map was cleared in that epoch."""
        self._may_forget = True
        self._tail_may_lead = True
        self._room = Room(mission)
        self.onward: tuple[Place, ...] = ()
        """The way on from the end of the newest step, which robots behind have to leave free (rule 8)."""
        self._keeps_way_free = False
        """Whether robots behind have once kept it from a turn."""
        self._failure: str | None = None
        self._bodies_may_move = False
        self._brief: Leader | None = None
        """It plans steps that are driven by moments (rule 6)."""
        if mission.obstacles_move and mission.watch_s > BRIEF_S:
            self._brief = Leader(msgspec.structs.replace(mission, watch_s=BRIEF_S), start)

    @property
    def steps(self) -> int:
        """Switching steps planned so far."""
        return self._steps

    @property
    def has_forgotten(self) -> bool:
        """Whether the map was cleared in this epoch."""
        return self._forgot

    def count_on(self, steps: int) -> None:
        """Count on from another leader's steps; half of all counts are left for steps that are to come."""
        self._steps = max(self._steps, min(steps, COUNT_MAX // 2))

    def release(self) -> None:
        """Give up the cells of the map: another robot leads."""
        self.map.release()
        if self._brief is not None:
            self._brief.release()

    def take_failure(self) -> str | None:
        """How the law has failed since this was last asked, if it has."""
        failure, self._failure = self._failure, None
        of_brief = None if self._brief is None else self._brief.take_failure()
        return failure or of_brief

    def is_done(self, position: Floats) -> bool:
        """Whether this is the last switching position: at the goal, or the last one requested."""
        if self._goal is not None:
            return float(np.hypot(*(self._goal - position))) <= self._mission.goal_tolerance_m
        return self._steps + 1 == self._mission.switching_positions_max

    def plan(
        self,
        view: View,
        ground: Ground,
        *,
        epoch: int,
        settled: bool,
        bodies_may_move: bool = False,
        may_forget: bool = True,
        all_stand: bool = False,
        tail_may_lead: bool = True,
    ) -> Plan:
        """The next switching step from a scan, as a timeline entry; or why there is none.

        Args:
            view: the scan.
            ground: the ground that robots behind may occupy.
            epoch: the strand's epoch.
            settled: whether the robots behind have closed up.
            bodies_may_move: whether a body in the way may move away again, from now on.
            may_forget: whether the map may be cleared (rule 5).
            all_stand: whether what was in the way has not gone for a while.
            tail_may_lead: whether the tail may lead out of a dead end from where it stands.
        """
        self._bodies_may_move |= bodies_may_move
        self._may_forget = may_forget
        self._tail_may_lead = tail_may_lead
        self.onward = ()
        if self._visited.epoch != epoch:
            self._visited, self._forgot = Visited(epoch), False
        if not self._world_changes:
            is_closest = closer(self._mission, len(view.ranges_m)) is None
            view = self._visited.narrow(view, is_closest=is_closest)
        sight = look(view, self._mission)
        walls = self._walls(scan_walls(view, self._mission), ground)
        step: Step | Plan
        if self._goal is None or not self._mission.promises_clearance:
            step = self._step_on(sight, walls, ground)
        else:
            # For guidance alone, which only ranks: the certificate takes no hit for a robot.
            known = view.without_on([ground.occupied], within_m=self._mission.hull_reach_m)
            seen = replace(sight, view=known)
            step = self._step_to(self._goal, seen, walls, ground, settled=settled)
            is_blocked = isinstance(step, DeadEnd) or (all_stand and isinstance(step, NoStep | Wait))
            if self._brief is not None and is_blocked:
                step = self._brief.brief_step(self._goal, seen.view, self.map, ground) or step
        if not isinstance(step, Step):
            return step
        if self._wanders(view.position):
            return self._no_way("every step from here has led back here")
        return self._record(step, sight, ground, epoch)

    def brief_step(self, goal: Floats, view: View, known: Map, ground: Ground) -> Step | LookCloser | None:
        """Rule 6: a step that is driven by moments, with what another leader's map knows."""
        self.map.forget()
        self.map.remember(known.hits)
        walls = self._walls(scan_walls(view, self._mission), ground)
        step = self._step_to(goal, look(view, self._mission), walls, ground, settled=True)
        return step if isinstance(step, Step | LookCloser) else None

    def _wanders(self, here: Floats) -> bool:
        """Whether it has planned from here too often (rule 4)."""
        if self._mission.obstacles_move or not self._mission.promises_clearance:
            return False
        return self._visited.too_often(here, near_m=AGAIN_CELLS * self.map.cell_m)

    def make_room(self, view: View, ground: Ground, *, epoch: int, room_m: float) -> StepPlanned | NoStep:
        """A step away, so that the robots behind can drive `room_m` further."""
        self.onward = ()
        walls = self._walls(scan_walls(view, self._mission), ground)
        step = self._room.step(self.map, view, walls, ground, epoch=epoch, room_m=room_m)
        if step is None:
            return NoStep("both ends of the strand are in dead ends, and neither can make room for the other")
        return self._record(replace(step, cost_to_go_m=None), look(view, self._mission), ground, epoch)

    def _walls(self, shown: Walls, ground: Ground | None = None) -> Walls:
        """What a step keeps off: what a scan has shown, the ground of robots behind, and the bounds."""
        bounds, behind = self._mission.bounds, [] if ground is None else [ground.walls]
        sides = [] if bounds is None else [bounds_walls(bounds, self._mission)]
        return Walls.joined(shown, *behind, *sides)

    def _ask(
        self, sight: Sight, walls: Walls, ground: Ground, ways: Callable[[], CostToGo] | None = None
    ) -> Step | Refused:
        """Ask the law of the mission; the robot's process has loaded it before."""
        come = ground.come
        seen = Seen(sight, walls, self._mission, self._onward_rad, self._steps, self.map.hits, come, ways)
        said = asked(find(self._mission.law), seen)
        if isinstance(said, Refused) and said.why is Why.FAILED:
            self._failure = said.reason
        return said

    def _step_on(self, sight: Sight, walls: Walls, ground: Ground) -> Step | NoStep | Crossed:
        """Without a goal, or a certificate: if no step is left and the way is open, it has crossed."""
        step = self._ask(sight, walls, ground)
        if isinstance(step, Step):
            return step
        proposes_nothing = self._mission.promises_clearance and step.why is Why.NOTHING
        crossed = proposes_nothing and is_open(sight, self._onward_rad)
        return Crossed() if crossed else NoStep(step.reason)

    def _step_to(
        self, goal: Floats, sight: Sight, walls: Walls, ground: Ground, *, settled: bool
    ) -> Step | NoStep | LookCloser | Wait | DeadEnd:
        view = sight.view
        if self._world_changes:
            self.map.forget_where_free(view)
        self.map.remember(view.hit_points)
        reason = ""
        for _ in range(SPOTS_MAX):
            ways = cache(partial(self._cost_to_go, goal, ground.taken, origin=view.position))
            step = self._ask(sight, walls, ground, ways)
            if isinstance(step, Step):
                self.onward = self._way_on(step.target(view.position), ways, ground.keep_m)
                return step
            reason, goes_by_ways = step.reason, ways.cache_info().currsize > 0
            if step.why is Why.FAILED:
                break
            none_nearer = self._mission.law == CERTIFIED and step.why is Why.NOTHING
            if not has_way(view, walls, ways(), none_nearer=none_nearer):
                return self._turn_back(goal, view, ground, settled=settled)
            if closer(self._mission, len(view.ranges_m)) is not None:
                return LookCloser()
            way = ways().way_from(view.position, cells_max=WAY_CELLS)
            refused = refused_at(view, walls, way)
            if not goes_by_ways or refused == len(way):  # it says the same until the robots behind make room
                return self._no_way(reason) if settled else Wait()
            if (other := self._without_closing(goal, sight, ground, ways, settled=settled)) is not None:
                return other
            self._close(view, way, refused)
        return self._no_way(reason)

    def _without_closing(
        self, goal: Floats, sight: Sight, ground: Ground, ways: Callable[[], CostToGo], *, settled: bool
    ) -> Step | NoStep | Wait | DeadEnd | None:
        """What may still help where a way is refused, if no spot of it is to blame (rules 7 and 8)."""
        if (short := self._short_step(sight, ground, ways)) is not None:
            self.onward = self._way_on(short.target(sight.view.position), ways, ground.keep_m)
            return short
        if not self._is_held(sight, ground, ways):
            return None
        back = self._turn_back(goal, sight.view, ground, settled=settled)
        self._keeps_way_free = isinstance(back, DeadEnd)
        return back

    def _is_held(self, sight: Sight, ground: Ground, ways: Callable[[], CostToGo]) -> bool:
        """Whether only ground that is granted refuses all steps, for the first time (rule 8)."""
        if self._world_changes or self._keeps_way_free:
            return False
        alone = self._walls(scan_walls(sight.view, self._mission))
        return isinstance(self._ask(sight, alone, ground, ways), Step)

    def _way_on(self, place: Floats, ways: Callable[[], CostToGo], keep_m: float) -> tuple[Place, ...]:
        """The way on from a place that robots behind have to leave free (rule 8)."""
        if not self._keeps_way_free:
            return ()
        cells = math.ceil(ONWARD_KEEPS * keep_m / self.map.cell_m)
        return tuple((x_m, y_m) for x_m, y_m in ways().way_from(place, cells_max=cells).tolist())

    def _short_step(self, sight: Sight, ground: Ground, ways: Callable[[], CostToGo]) -> Step | None:
        """A step to another place to look from, if the ground up to there is clear but for hidden corners."""
        if self._world_changes or sight.view.earlier:
            return None
        walls = self._walls(short_step_walls(sight.view, self._mission), ground)
        step = self._ask(sight, walls, ground, ways)
        if not isinstance(step, Step):
            return None
        return replace(step, length_m=min(step.length_m, short_step_m(self._mission)), cost_to_go_m=None)

    def _cost_to_go(self, goal: Floats, taken: Floats, *, origin: Floats | None = None) -> CostToGo:
        tolerance_m, keep_m = self._mission.goal_tolerance_m, self._mission.robot_keep_m
        return self.map.cost_to_go(goal, tolerance_m=tolerance_m, taken=taken, keep_m=keep_m, origin=origin)

    def _close(self, view: View, way: Floats, refused: int) -> None:
        """Close the narrowest spot of a way refused from that point on; only for now if robots are why."""
        off_first_m = np.hypot(*(way[refused:] - way[refused]).T)
        spot = self.map.narrowest(way[refused:][off_first_m <= 2.0 * self._mission.obstacle_keep_m])
        robots = ~view.hits & (view.ranges_m < self._mission.range_m_max)
        alone = self._walls(scan_walls(view, self._mission, leave_out=robots))
        still = not self._world_changes
        self.map.close(spot, for_good=still and refused_at(view, alone, way) <= refused)

    def _turn_back(
        self, goal: Floats, view: View, ground: Ground, *, settled: bool
    ) -> NoStep | Wait | DeadEnd:
        """What to do if no way leads past the strand."""

        def reachable(place: Floats, taken: Floats) -> bool:
            return bool(np.isfinite(self._cost_to_go(goal, taken).at(place[None])[0]))

        alone = self._walls(scan_walls(view, self._mission))
        cost_to_go = self._cost_to_go(goal, np.empty((0, 2)))
        # The leader can go back the way it came, even if hulls stand all around it now.
        come_m = cost_to_go.at(ground.come)
        if not len(ground.taken) or not (has_way(view, alone, cost_to_go) or np.isfinite(come_m).any()):
            return self._no_way(NO_WAY.reason)
        if not settled:
            return Wait()
        return DeadEnd(
            way_back_m(ground, self._mission.obstacle_keep_m, reachable, tail_may_lead=self._tail_may_lead)
        )

    def _no_way(self, reason: str) -> NoStep:
        """Report that no way is left. Where obstacles move, refused spots may be free at the next scan.

        They are reopened only here: a spot that reopens with every scan is approached and refused for ever.
        Traces of bodies that have moved on may stay in the map, hidden by other bodies (rule 5).
        """
        if self._world_changes:
            self.map.reopen()
        if self._bodies_may_move and self._may_forget and not self._forgot:
            self._forgot = True
            self.map.forget()
        return NoStep(reason)

    @property
    def _world_changes(self) -> bool:
        return self._mission.obstacles_move or self._bodies_may_move

    def _record(self, step: Step, sight: Sight, ground: Ground, epoch: int) -> StepPlanned:
        """Count a step, and say what is planned."""
        self._steps += 1
        behind = on_ground(sight.view.points, ground.behind, within_m=self._mission.hull_reach_m)
        target = step.target(sight.view.position)
        reach_m = ground.path.end_m + float(np.hypot(*(target - xy(ground.path.at(ground.path.end_m)))))
        return planned(
            step,
            sight.view,
            behind,
            self._mission,
            number=self._steps,
            epoch=epoch,
            reach_m=reach_m,
            sight=sight,
        )
