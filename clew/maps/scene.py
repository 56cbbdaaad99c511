"""Makes a scene of a map.

Rule 1: what lies beyond the image is unknown, so the outermost obstacle is a rim around it, one cell wide.
"""

import math
from typing import Any

import numpy as np

from clew.maps.occupancy import Map
from clew.maps.outlines import coarsened, outlines, pieces_min
from protocol.arrays import Floats
from protocol.errors import UsageError
from world.scenario.scenario import OBSTACLES_MAX

DECIMALS = 12  # of a metre: 0.15 instead of 0.15000000000000002; as near as sums of such numbers come anyway


def scene(
    ground: Map,
    name: str,
    *,
    start: tuple[float, float, float],
    goal_m: tuple[float, float],
    robot_radius_m: float,
    coarsen: int = 1,
) -> dict[str, Any]:
    """The map as a `clew-scene/1` [m, rad; world frame].

    Args:
        ground: the map.
        name: of the scene.
        start: of the first robot: x, y, heading.
        goal_m: where the leader has to come.
        robot_radius_m: of each robot.
        coarsen: cells along x and y that count as one, which is an obstacle if any of them is.

    Raises:
        UsageError: no cell is free, or there are more obstacles than a scenario may have.
    """
    blocked = coarsened(ground.blocked, coarsen)
    if blocked.all():
        raise UsageError("no cell is free")
    walled = np.pad(blocked, 1, constant_values=True)  # rule 1
    rings = outlines(walled) if (count := pieces_min(walled)) <= OBSTACLES_MAX else []
    if (count := max(count, len(rings))) > OBSTACLES_MAX:
        most = f"must have at most {OBSTACLES_MAX} obstacles, got {count} or more"
        raise UsageError(f"{most}; try --coarsen {2 * coarsen}")
    free_y, free_x = np.nonzero(~walled)
    low, high = (free_x.min(), free_y.min()), (free_x.max() + 1, free_y.max() + 1)
    box = np.array([low, (high[0], low[1]), high, (low[0], high[1])], dtype=np.float64)
    bounds_m = _placed(box, ground, coarsen)
    return {
        "schema": "clew-scene/1",
        "name": name,
        "units": "m",
        "robot_radius": robot_radius_m,
        "start": start,
        "goal": goal_m,
        "goal_tol": robot_radius_m,
        "bounds": [*bounds_m.min(axis=0).tolist(), *bounds_m.max(axis=0).tolist()],
        "circles": [],
        "polygons": [_placed(ring, ground, coarsen).tolist() for ring in rings],
    }


def _placed(corners: Floats, ground: Map, coarsen: int) -> Floats:
    """Corners in cells of the walled grid, in the world frame."""
    x_m, y_m, yaw_rad = ground.origin
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    in_map_m = (corners - 1.0) * coarsen * ground.resolution_m
    turned_m = in_map_m @ np.array([[cosine, sine], [-sine, cosine]])
    return np.asarray(np.round(turned_m + np.array((x_m, y_m)), DECIMALS))
