"""ir-sim, a simulator of mobile robots in Python, on the scene of a rehearsal: as a baseline.

Rule 1: the same obstacles, hulls, starts, goal and speed. Its step is the period of odometry, at which the
        robots of a rehearsal decide. An ellipse is a polygon there.
Rule 2: it does least: robots drive straight for the goal, do not sense, and pass through what they meet. So
        no message, plan, record or judgement is in its time, and none that we could leave out.
Rule 3: only steps are timed, not the import and the making of the world; nothing is drawn.
"""

import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import msgspec

from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape
from world.scenario.scenario import Scenario

STEP_S = ODOMETRY_TICKS * TICK_S
CORNERS = 24  # of an ellipse: off by less than 1 % of its axis


def stepper(scenario: Scenario) -> Callable[[float], None]:
    """A world of ir-sim with this scene and fleet; returns what makes it simulate so many seconds.

    Raises:
        ImportError: ir-sim is not installed.
    """
    with redirect_stdout(sys.stderr):  # on import it says which backends for drawing it did not find
        import irsim  # noqa: PLC0415 - an extra

    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / "world.yaml"
        world.write_bytes(msgspec.json.encode(world_of(scenario)))  # JSON is YAML, too
        env = irsim.make(str(world), headless=True, log_level="ERROR")

    def simulate(for_s: float) -> None:
        for _ in range(round(for_s / STEP_S)):
            env.step()

    return simulate


def world_of(scenario: Scenario) -> dict[str, Any]:
    """The scene in the words of ir-sim."""
    goal = scenario.mission().goal
    assert goal is not None, "a scene without a goal has no baseline"
    bounds, radius_m = scenario.bounds, scenario.fleet.robot_radius_m
    sides = (
        {}
        if bounds is None
        else {
            "width": bounds.x_m_max - bounds.x_m_min,
            "height": bounds.y_m_max - bounds.y_m_min,
            "offset": [bounds.x_m_min, bounds.y_m_min],
        }
    )
    robots = [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": radius_m},
            "state": [pose.x_m, pose.y_m, pose.heading_rad],
            "goal": [goal.x_m, goal.y_m, 0.0],
            "behavior": {"name": "dash"},
            "vel_max": [scenario.drive.speed_mps, scenario.drive.turn_rate_radps],
        }
        for pose in scenario.fleet.poses()
    ]
    return {
        "world": {**sides, "step_time": STEP_S, "sample_time": STEP_S, "collision_mode": "unobstructed"},
        "robot": robots,
        "obstacle": [_obstacle(shape) for shape in scenario.obstacles],
    }


def _obstacle(shape: Shape) -> dict[str, Any]:
    match shape:
        case Circle(centre_m=(x_m, y_m), radius_m=radius_m):
            return {"shape": {"name": "circle", "radius": radius_m}, "state": [x_m, y_m, 0.0]}
        case Polygon(vertices_m=vertices):
            return _polygon(vertices)
        case Ellipse(centre_m=(x_m, y_m), semi_axes_m=(a_m, b_m), rotation_rad=turned_rad):
            corners = [
                (a_m * math.cos(math.tau * k / CORNERS), b_m * math.sin(math.tau * k / CORNERS))
                for k in range(CORNERS)
            ]
            cosine, sine = math.cos(turned_rad), math.sin(turned_rad)
            return _polygon([(x_m + cosine * x - sine * y, y_m + sine * x + cosine * y) for x, y in corners])


def _polygon(vertices: Sequence[tuple[float, float]]) -> dict[str, Any]:
    return {"shape": {"name": "polygon", "vertices": [list(each) for each in vertices]}}
