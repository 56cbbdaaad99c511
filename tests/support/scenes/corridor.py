"""A passage one robot wide between two rooms: a body that stands in it plugs the way. Not a test file."""

import shapely

from tests.support.scenes.dead_ends import SPACING_M, corridors, scene, walls_round
from world.scenario.scenario import Scenario

PASSAGE_M = 2.4  # the queue of eight robots is 2.1 m long
ROOM_M = 2.0


def passage(robots: int) -> Scenario:
    """All robots queue in the room on the left; the passage begins at x = 0, the goal lies beyond."""
    queue_m = SPACING_M * robots
    left = shapely.box(-queue_m - 1.0, -1.0, 0.0, 1.0)
    right = shapely.box(PASSAGE_M, -1.0, PASSAGE_M + ROOM_M + queue_m, 1.0)
    free = shapely.union_all([left, right, corridors([(-0.1, 0.0), (PASSAGE_M + 0.1, 0.0)])])
    return scene(
        walls_round(free),
        robots=robots,
        start=(-0.4, 0.0, 0.0),
        goal=(PASSAGE_M + ROOM_M + queue_m - 1.0, 0.0),
        time_s_max=300.0,
    )
