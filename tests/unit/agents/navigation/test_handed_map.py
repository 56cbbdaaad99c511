"""The map of a leader that lies, handed to the next one."""

import math

import numpy as np
import pytest

from agents.navigation.guidance import Map
from tests.support.stages.one_step import under

MISSION = under("certified", robot_radius_m=0.1)
START, GOAL = np.array([0.0, 0.0]), np.array([3.0, 0.0])
WALL = np.array([(1.5, y_m) for y_m in np.arange(-1.0, 1.0, 0.05)])


@pytest.mark.parametrize("far_m", [200.0, 1e6])
def test_a_leader_that_lies_leaves_its_successor_a_map_to_plan_with(far_m: float) -> None:
    """Hits far off, where there are no bounds, made cells of kilometres, and no later leader saw a way."""
    liar, successor = Map(MISSION, START), Map(MISSION, START)
    liar.remember(np.concatenate([WALL, [[far_m, far_m], [-far_m, -far_m]]]))
    successor.unpack(liar.packed())
    assert successor.cell_m <= MISSION.obstacle_keep_m
    cost_m = float(successor.cost_to_go(GOAL, tolerance_m=0.1).at(START[None])[0])
    assert math.dist(START, GOAL) < cost_m < math.inf, "the wall that is near counts"
