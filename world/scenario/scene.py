"""`clew-scene/1`: converts obstacle scenes in JSON to scenarios."""

import math
import re
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.frames import Metres, wrap
from protocol.mission import robot_keep_m
from world.geometry.moving import Name, Track, speed_mps_max
from world.geometry.shapes import Extent, Position, Shape
from world.scenario.budget import HEADING_ERRORS, NOISE_SIGMAS
from world.scenario.sections import TIME_S_MAX, SomeMetres

ROBOTS = 5  # the paper's fleet
EPSILON_M_MAX, EPSILON_RADII = 0.05, 0.5  # half the radius, at most 5 cm
MU0_SHARE = 0.1  # of epsilon, as in the paper
DIRECTIONS = 360  # 1 degree, as common low-cost scanners have
SPEED_MPS, SPEED_MPS_MIN, SPEED_MPS_MAX = 0.5, 0.05, 1.0  # a small indoor robot's
TURN_RATE_RADPS = 1.5708  # a quarter turn a second
RANGE_M_MAX = 4.0  # as in the trial of the certified law on the BARN worlds
RANGE_RADII = 20.0  # for large robots: range in radii
SPACING_RADII = 3.0  # the rule of the scenes for places of robots
LINK_RADII = 10.0  # three places, and some slack
ERROR_SHARE = 0.25  # of the tolerance, for noise and drive each; about half remains as reserve
TIME_FACTOR = 8.0  # times the longest way at full speed: twice the most of 25 combs of dead ends
WALL_SHARE = 1.0  # the width of walls between ways, in widths of a way

OWN_PATHS = {
    "$.fleet.start": "$.start",
    "$.goal.at_m": "$.goal",
    "$.bounds.x_m_min": "$.bounds[0]",
    "$.bounds.y_m_min": "$.bounds[1]",
}
"""The paths in a scene of the fields that a refusal of its scenario names."""


class _Mover(Struct, frozen=True, kw_only=True):
    """A disc on a track."""

    id: Name | int
    radius: Extent
    track: Track


class Scene(Struct, frozen=True, kw_only=True):
    """The keys of a scene that we use; others, about its origin, are ignored.

    `circles` and `polygons` are required but may be empty: otherwise a misspelt key would mean no obstacles.
    """

    schema: Literal["clew-scene/1"]
    name: str
    units: Literal["m"] = "m"
    robot_radius: SomeMetres
    start: tuple[Metres, Metres, Metres]
    goal: tuple[Metres, Metres]
    goal_tol: SomeMetres
    bounds: tuple[Metres, Metres, Metres, Metres]
    circles: tuple[tuple[Metres, Metres, Extent], ...]
    polygons: tuple[Annotated[tuple[Position, ...], Meta(min_length=3)], ...]
    walls: tuple[Annotated[tuple[Position, ...], Meta(min_length=3)], ...] = ()
    moving: tuple[_Mover, ...] = ()
    time_s_max: Annotated[float, Meta(gt=0.0, le=TIME_S_MAX)] | None = None


class _Obstacles(Struct, frozen=True, kw_only=True):
    obstacle: tuple[Shape, ...]


def as_scenario(raw: dict[str, Any], source: str) -> dict[str, Any]:
    """The scene as the content of a scenario file; `source` names it in error messages.

    The noise of sensor and drive is chosen to fit the tolerance.
    """
    scene = understand(raw, Scene, source)
    obstacles = [{"shape": "circle", "centre_m": (x, y), "radius_m": r} for x, y, r in scene.circles]
    obstacles += [{"shape": "polygon", "vertices_m": ring} for ring in (*scene.polygons, *scene.walls)]
    try:
        understand({"obstacle": obstacles}, _Obstacles, source)
    except UsageError as error:
        raise UsageError(in_own_words(str(error), raw)) from error
    radius_m = scene.robot_radius
    range_m_max = max(RANGE_M_MAX, RANGE_RADII * radius_m)
    epsilon_m = min(EPSILON_M_MAX, EPSILON_RADII * radius_m)
    mu0_m = MU0_SHARE * epsilon_m
    share_m = ERROR_SHARE * mu0_m
    x_m_min, y_m_min, x_m_max, y_m_max = scene.bounds
    mover_mps = max((speed_mps_max(each.track) for each in scene.moving), default=0.0)
    keep_m = robot_keep_m(
        robot_radius_m=radius_m, separation_m=epsilon_m, mu0_m=mu0_m, obstacle_speed_mps_max=mover_mps
    )
    return {
        "name": scene.name,
        "fleet": {
            "robots": ROBOTS,
            "robot_radius_m": radius_m,
            "separation_m": epsilon_m,  # a dead robot is an obstacle like any other
            "link_length_m_max": LINK_RADII * radius_m,
            "start": (*scene.start[:2], wrap(scene.start[2])),
            "spacing_m": max(SPACING_RADII * radius_m, keep_m + mu0_m),
        },
        "law": {"epsilon_m": epsilon_m, "mu0_m": mu0_m},
        "goal": {"at_m": scene.goal, "tolerance_m": scene.goal_tol},
        "bounds": {"x_m_min": x_m_min, "y_m_min": y_m_min, "x_m_max": x_m_max, "y_m_max": y_m_max},
        "sensor": {
            "directions": DIRECTIONS,
            "range_m_max": range_m_max,
            "range_sigma_m": share_m / NOISE_SIGMAS,
        },
        "drive": {
            "speed_mps": SPEED_MPS,
            "speed_mps_min": SPEED_MPS_MIN,
            "speed_mps_max": SPEED_MPS_MAX,
            "turn_rate_radps": TURN_RATE_RADPS,
            "heading_error_rad": share_m / (HEADING_ERRORS * range_m_max),
        },
        "time": {"time_s_max": scene.time_s_max or time_s(scene, radius_m + epsilon_m)},
        "obstacle": obstacles,
        "moving": [
            {"shape": "circle", "id": str(each.id), "radius_m": each.radius, "track": each.track}
            for each in scene.moving
        ],
    }


def time_s(scene: Scene, closest_m: float) -> float:
    """The time limit by the size of the ground: for the longest way that fits into it.

    A way takes up its own width and that of a wall, all over the ground. The straight way may be longer.
    """
    x_m_min, y_m_min, x_m_max, y_m_max = scene.bounds
    width_m = 2.0 * closest_m * (1.0 + WALL_SHARE)
    winding_m = (x_m_max - x_m_min) * (y_m_max - y_m_min) / width_m
    straight_m = max(math.dist(scene.start[:2], scene.goal), RANGE_M_MAX)
    return min(TIME_FACTOR * max(winding_m, straight_m) / SPEED_MPS, TIME_S_MAX)


def in_own_words(refusal: str, raw: dict[str, Any]) -> str:
    """A refusal of the scenario made from a scene, with the scene's own paths."""

    def own(obstacle: re.Match[str]) -> str:
        index = int(obstacle["index"])
        for key in ("circles", "polygons", "walls"):
            if index < len(raw.get(key, ())):
                return f"$.{key}[{index}]"
            index -= len(raw.get(key, ()))
        raise AssertionError(obstacle)  # each obstacle of the scenario is one of the scene's

    for theirs, ours in OWN_PATHS.items():
        refusal = refusal.replace(theirs, ours)
    return re.sub(r"\$\.obstacle\[(?P<index>\d+)\]", own, refusal)
