"""A random deployment: free places for a fleet, drawn by the run's seed."""

import numpy as np

from protocol.frames import Pose
from protocol.mission import Bounds
from world.chance import stream
from world.clearance import distances
from world.shapes import Ground

TRIES = 10_000  # places drawn for each robot: where one in a thousand is free, all but 5 in 100,000 are found


def free_places(
    robots: int, bounds: Bounds, ground: Ground, *, seed: int, hull_m: float, clear_m: float, apart_m: float
) -> tuple[Pose, ...] | None:
    """Where robots may start; None where so many are not found room for.

    Args:
        robots: how many.
        bounds: the rectangle that no hull may leave.
        ground: the obstacles.
        seed: the run's; with as many robots or more, the first of them start at the same places.
        hull_m: a robot's radius.
        clear_m: least distance of a centre from an obstacle.
        apart_m: least distance between two centres.
    """
    chance = stream(seed, "deployment")
    low = np.array([bounds.x_m_min, bounds.y_m_min]) + hull_m
    high = np.array([bounds.x_m_max, bounds.y_m_max]) - hull_m
    poses: list[Pose] = []
    for _ in range(robots):
        for _ in range(TRIES):
            place = chance.uniform(low, high)
            heading_rad = float(chance.uniform(-np.pi, np.pi))
            off_m = [np.hypot(place[0] - pose.x_m, place[1] - pose.y_m) for pose in poses]
            free = ground.shape_count == 0 or distances(ground, place).min() >= clear_m
            if free and all(each >= apart_m for each in off_m):
                poses.append(Pose(x_m=float(place[0]), y_m=float(place[1]), heading_rad=heading_rad))
                break
        else:
            return None
    return tuple(poses)
