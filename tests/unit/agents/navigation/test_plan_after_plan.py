"""What a map keeps from plan to plan changes no cost."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.guidance import Map
from protocol.arrays import Floats
from protocol.mission import Bounds
from tests.support.stages.one_step import under

BOUNDS = Bounds(x_m_min=-1.0, y_m_min=-2.0, x_m_max=3.0, y_m_max=1.0)
ROBOT = under("certified", robot_radius_m=0.1, bounds=BOUNDS)
GOAL = np.array([2.03, -0.52])
inside = st.tuples(st.floats(-0.8, 2.8), st.floats(-1.8, 0.8))
hits = st.lists(inside, max_size=12).map(lambda found: np.array(found).reshape(-1, 2))


@given(st.lists(st.tuples(hits, inside.map(np.array)), min_size=2, max_size=4))
def test_the_costs_of_plan_after_plan_are_those_of_a_new_map(plans: list[tuple[Floats, Floats]]) -> None:
    region = Map(ROBOT, GOAL)
    for count, (hit_points, origin) in enumerate(plans, start=1):
        region.remember(hit_points)
        new = Map(ROBOT, GOAL)
        for earlier, _ in plans[:count]:
            new.remember(earlier)
        taken = np.stack([origin, origin + 0.1])
        asked = region.cost_to_go(GOAL, tolerance_m=0.0, taken=taken, keep_m=0.2, origin=origin)
        everywhere = new.cost_to_go(GOAL, tolerance_m=0.0, taken=taken, keep_m=0.2)
        there_m = everywhere.at(origin[None])[0]
        assert asked.at(origin[None])[0] == there_m
        near = everywhere.cells <= there_m
        assert (asked.cells[near] == everywhere.cells[near]).all()
        assert (np.isinf(asked.cells) | (asked.cells == everywhere.cells)).all()
