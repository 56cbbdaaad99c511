"""How a plan's time grows with the map: plans near one place, with more and more scans of other places.

Rule 1: the field is wide and has no bounds, so the map grows outwards with each scan.
Rule 2: at each size, the leader and the textbook planner know the same scans, and plan from the same places,
        once before they are timed, as in a run.
"""

from collections.abc import Sequence

import msgspec
import numpy as np

from agents.navigation.ground import Ground
from agents.navigation.scan import View, view
from agents.strand.leader import Leader
from clew.bench.plan import Clock, Sample
from clew.bench.planners.textbook import Textbook
from clew.fields.field import Field, scene
from clew.fields.kinds import Kind
from protocol.arrays import scan_bearings_rad, xy
from protocol.fence import Fence
from protocol.frames import Point, Pose
from protocol.path import Path
from protocol.timeline import StepPlanned
from protocol.wire.messages import Scan
from world.chance import stream
from world.geometry.rays import cast
from world.scenario.scenario import Scenario
from world.scenario.scene import as_scenario

SEED = 1
SIDE_M = 30.0
PLANS = 5  # timed at each size of the map


def field() -> Scenario:
    """The field that is mapped."""
    drawn = scene(Field(kind=Kind.MIXED, seed=SEED, size_m=(SIDE_M, SIDE_M)))
    scenario = msgspec.convert(as_scenario(drawn, "growing"), Scenario)
    return msgspec.structs.replace(scenario, bounds=None)


def views(scenario: Scenario, count: int) -> list[View]:
    """Scans without noise from random free places, the nearest to the middle of the field first.

    There are enough for all plans.
    """
    chance, mission = stream(SEED, "growing"), scenario.mission()
    found: list[View] = []
    while len(found) < max(count, PLANS + 1):
        x_m, y_m = chance.uniform(0.0, SIDE_M, size=2).tolist()
        seen = _scan(scenario, Pose(x_m=x_m, y_m=y_m, heading_rad=0.0))
        if seen.ranges_m.min() > 2.0 * mission.obstacle_keep_m:
            found.append(seen)
    middle = np.array([SIDE_M / 2.0, SIDE_M / 2.0])
    return sorted(found, key=lambda each: float(np.hypot(*(each.position - middle))))


def _scan(scenario: Scenario, at: Pose) -> View:
    mission = scenario.mission()
    bearings_rad = scan_bearings_rad(mission.revolutions * mission.directions)
    ranges_m = cast(
        scenario.ground, xy(at), bearings_rad, range_m_max=mission.range_m_max, discs=np.empty((0, 3))
    )
    scan = Scan(t_s=0.0, pose=at, fence=Fence(), ranges_m=tuple(ranges_m.tolist()))
    return view(scan, range_m_max=mission.range_m_max)


def samples(scenario: Scenario, seen: Sequence[View], scans: int, *, cpu: Clock) -> list[Sample]:
    """Time plans in a map of so many of these scans; those from the nearest places."""
    mission, start = scenario.mission(), seen[0].position
    at = Pose(x_m=float(start[0]), y_m=float(start[1]), heading_rad=0.0)
    leader, textbook = Leader(mission, at), Textbook(mission)
    for each in seen[:scans]:
        leader.map.remember(each.hit_points)
        textbook.remember(each)
    found = []
    for each in seen[: PLANS + 1]:
        x_m, y_m = each.position.tolist()
        path = Path([Point(x_m=x_m, y_m=y_m)])
        alone = Ground(path, tail_m=0.0, granted_m=0.0, keep_m=0.0, behind_m=0.0)
        since_s = cpu()
        planned = leader.plan(each, alone, epoch=1, settled=True)
        plan_s, since_s = cpu() - since_s, cpu()
        textbook.plan(each)
        step_m = planned.length_m if isinstance(planned, StepPlanned) else 0.0
        found.append(Sample(plan_s, plan_s, {}, cpu() - since_s, step_m))
    return found[1:]
