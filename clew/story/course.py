"""The course of a run, as its figures draw it: where everybody was, and what the leader planned where. Pure.

Rule 1: positions, clearances and recoveries come from what judges the run; nothing is measured a second way.
Rule 2: a run that is cut off has a course as far as it goes.
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from clew.story.stands import Stand, stands_of
from clew.story.steps import Step
from clew.story.story import Story
from protocol.arrays import Floats
from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.timeline import PoseSampled, RouteLost
from world.judge.moves import Intervals, Moves
from world.judge.recovery import Recovery
from world.judge.tally import Tally
from world.scenario.scenario import Scenario


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """What is drawn of a run. Robot k is column k - 1; between two instants everybody moved straight."""

    scenario: Scenario
    times_s: Floats
    """`(k,)`, increasing; empty where the bodies were never placed."""
    places_m: Floats
    """`(k, n, 2)` [world frame]."""
    clearance_m: Floats
    """`(k, n)`: of each hull since the instant before, to the nearest obstacle that never moves."""
    stands: tuple[Stand, ...]
    """The switching positions, in the order in which a leader came there."""
    steps: tuple[Step, ...]
    """The switching steps that leaders planned."""
    orders: tuple[tuple[float, tuple[int, ...]], ...]
    """From when on which strand, leader first."""
    route_lost: tuple[tuple[float, int], ...]
    """When which leader found no way on; the first ended the run."""
    recovery: Recovery
    restarted: frozenset[int]
    """Robots in whose place a new process was started."""

    @property
    def robots(self) -> range:
        """The numbers of the robots."""
        return range(1, self.scenario.fleet.robots + 1)

    @property
    def dead(self) -> dict[int, float]:
        """Robots that died and never came back, and when."""
        gone = (death for death in self.recovery.deaths if death.returned_s is None)
        return {death.robot: death.cause_s for death in gone if death.robot not in self.restarted}

    @property
    def last(self) -> list[tuple[float, int]]:
        """The end, and who led then; nothing where the bodies were never placed."""
        end_s = float(self.times_s.max(initial=0.0))
        return [(end_s, next(iter(self.order_at(end_s)), 0))] if len(self.times_s) else []

    def body_end_s(self, robot: int) -> float:
        """Until when there is something to tell of its body: the dead drive on until they are stopped."""
        if robot not in self.dead:
            return float("inf")
        moved = np.diff(self.places_m[:, robot - 1], axis=0, prepend=self.places_m[:1, robot - 1]).any(axis=1)
        return max(self.dead[robot], float(self.times_s[moved].max(initial=0.0)))

    def order_at(self, t_s: float) -> tuple[int, ...]:
        """The newest strand by then, leader first; nobody before the first has formed."""
        return next((order for from_s, order in reversed(self.orders) if from_s <= t_s), ())

    def places_at_m(self, t_s: float) -> Floats:
        """Where everybody is, `(n, 2)` [world frame]."""
        flat = self.places_m.reshape(len(self.times_s), -1)
        return np.array([np.interp(t_s, self.times_s, column) for column in flat.T]).reshape(-1, 2)


def course_of(read: Timeline, stand_in: Scenario | None = None) -> Course:
    """The course of the run that a timeline tells of, or of its entries and a scenario to stand in.

    Raises:
        UsageError: the header's scenario is none, or of another version, and nothing stands in.
    """
    scenario = stand_in or scenario_of(read)
    story, tally, moving = Story(), Tally(), Moves(scenario.ground, scenario.fleet.robots)
    lost: list[tuple[float, int]] = []
    poses: defaultdict[int, list[tuple[float, PoseSampled]]] = defaultdict(list)
    moves: list[Intervals] = []
    for source, entry in read.lines:
        for each in (story, tally):
            each.hear(source, entry)
        if source == WORLD and isinstance(entry.record, PoseSampled):
            poses[entry.record.robot].append((entry.t_s, entry.record))
            moves += moving.hear(entry.t_s, entry.record)
        if isinstance(entry.record, RouteLost) and (robot := robot_number(source)) is not None:
            lost.append((entry.t_s, robot))

    def place_at(robot: int, t_s: float) -> Point | None:
        before = [pose for at_s, pose in poses[robot] if at_s <= t_s]
        return Point(x_m=before[-1].x_m, y_m=before[-1].y_m) if before else None

    moves += moving.close()
    steps = story.all_steps()
    strands = story.strands.formed.values()
    robots = scenario.fleet.robots
    clear_m = np.concatenate([np.empty((0, robots)), *(each.clear_m for each in moves)])
    return Course(
        scenario=scenario,
        times_s=np.array([t_s for each in moves for t_s in each.ends_s]),
        places_m=np.concatenate([np.empty((0, robots, 2)), *(each.ends_m for each in moves)]),
        clearance_m=clear_m - scenario.fleet.robot_radius_m,
        stands=stands_of(steps, place_at),
        steps=steps,
        orders=tuple(sorted((strand.t_s, strand.formed.order) for strand in strands)),
        route_lost=tuple(lost),
        recovery=Recovery(tally.recovery),
        restarted=frozenset(tally.restarted),
    )
