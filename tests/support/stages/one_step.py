"""One switching step of a law among shapes: scan, plan, and the true clearance of the step."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from msgspec.structs import replace

from agents.navigation.ground import Ground
from agents.navigation.scan import View, view
from agents.navigation.step import Crossed, LookCloser, NoStep
from agents.navigation.sure import closer
from agents.strand.leader import DeadEnd, Leader, Plan, Wait
from protocol.arrays import scan_bearings_rad
from protocol.fence import Fence
from protocol.frames import Point, Pose
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import StepPlanned
from protocol.wire.messages import Scan
from world.geometry.clearance import clearance
from world.geometry.rays import cast
from world.geometry.shapes import Polygon, Shape, ground_of

MISSION = Mission(
    robots=1,
    robot_radius_m=0.0,
    law="certified",
    epsilon_m=0.1,
    mu0_m=0.01,
    separation_m=0.05,
    speed_mps=0.3,
    directions=1440,
    revolutions=1,
    range_m_max=4.0,
    range_error_m_max=0.0,
    sharpest_corner_rad=np.pi / 2.0,
    link_length_m_max=1.0,
)

ORIGIN = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)


def under(law: str, **other: object) -> Mission:
    """The mission above, under another law."""
    return replace(MISSION, law=law, **other)


def wall(*corners: tuple[float, float], thick_m: float = 0.02) -> Polygon:
    """A thin wall along a straight line; its face is the line, its body is to the left."""
    (x_0, y_0), (x_1, y_1) = corners
    along = np.array([x_1 - x_0, y_1 - y_0]) / np.hypot(x_1 - x_0, y_1 - y_0)
    left = thick_m * np.array([-along[1], along[0]])
    far_1, far_0 = (x_1 + left[0], y_1 + left[1]), (x_0 + left[0], y_0 + left[1])
    return Polygon(vertices_m=((x_0, y_0), (x_1, y_1), far_1, far_0))


def look_around(
    shapes: Sequence[Shape], mission: Mission, at: Pose = ORIGIN, *, revolutions: int = 1
) -> View:
    """A scan without noise."""
    ranges = cast(
        ground_of(shapes),
        np.array([at.x_m, at.y_m]),
        scan_bearings_rad(revolutions * mission.directions),
        range_m_max=mission.range_m_max,
        discs=np.zeros((0, 3)),
    )
    return view(
        Scan(t_s=0.0, pose=at, fence=Fence(), ranges_m=tuple(ranges.tolist())),
        range_m_max=mission.range_m_max,
    )


def alone(at: Pose = ORIGIN) -> Ground:
    """There is no robot behind."""
    path = Path([Point(x_m=at.x_m, y_m=at.y_m)])
    return Ground(path, tail_m=0.0, granted_m=0.0, keep_m=0.0, behind_m=0.0)


@dataclass(frozen=True)
class Driven:
    """A step, and the least clearance along it."""

    planned: StepPlanned
    clearance_m: float


def plan(
    leader: Leader,
    shapes: Sequence[Shape],
    mission: Mission,
    ground: Ground,
    *,
    at: Pose = ORIGIN,
    settled: bool = True,
    tail_may_lead: bool = True,
) -> Plan:
    """The leader's plan among these shapes; it may scan again for a closer look."""
    seen = look_around(shapes, mission, at)
    ask = partial(leader.plan, ground=ground, epoch=1, settled=settled, tail_may_lead=tail_may_lead)
    while isinstance(planned := ask(seen), LookCloser):
        seen = look_around(shapes, mission, at, revolutions=closer(mission, len(seen.ranges_m)) or 1)
    return planned


def step_through(shapes: Sequence[Shape], mission: Mission, at: Pose = ORIGIN) -> Driven | NoStep | Crossed:
    """Plan one step of a single robot and measure its clearance."""
    planned = plan(Leader(mission, at), shapes, mission, alone(at), at=at)
    assert not isinstance(planned, LookCloser | Wait | DeadEnd), f"{planned} of a robot alone"
    if not isinstance(planned, StepPlanned):
        return planned
    ends = np.array([[planned.target.x_m, planned.target.y_m]])
    measured = float(clearance(ground_of(shapes), np.array([[at.x_m, at.y_m]]), ends)[0])
    return Driven(planned, measured - mission.robot_radius_m)
