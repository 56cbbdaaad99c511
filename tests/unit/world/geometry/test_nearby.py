import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.strategies.shape_strategies import shapes
from world.geometry.clearance import clearance_at
from world.geometry.nearby import Nearby
from world.geometry.shapes import Polygon, Shape, ground_of

quietly = settings(deadline=None)  # the machine may be busy


@quietly
@given(st.lists(shapes, max_size=5), st.integers(0, 2**32), st.floats(0.001, 1.0))
def test_the_clearance_along_a_way_is_that_of_each_point_by_itself(
    obstacles: list[Shape], seed: int, step_m: float
) -> None:
    ground, chance = ground_of(obstacles), np.random.default_rng(seed)
    steps_m = step_m * chance.uniform(-0.2, 1.0, (200, 2)) * np.where(chance.uniform(size=2) < 0.5, -1.0, 1.0)
    way_m = chance.uniform(-4.0, 4.0, 2) + np.cumsum(steps_m, axis=0)
    nearby = Nearby(ground)
    along_m = [nearby.clearance_m(x_m, y_m) for x_m, y_m in way_m.tolist()]
    assert along_m == pytest.approx(clearance_at(ground, way_m).tolist(), abs=1e-9)


def test_deep_inside_a_polygon_the_clearance_is_0_whatever_was_asked_before() -> None:
    hall = Polygon(vertices_m=((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0)))
    nearby = Nearby(ground_of([hall]))
    for x_m, clear_m in ((-1.0, 1.0), (4.5, 0.0), (4.6, 0.0), (-2.0, 2.0), (-1.9, 1.9), (0.1, 0.0)):
        assert nearby.clearance_m(x_m, 4.5) == pytest.approx(clear_m)


def test_without_obstacles_everything_is_infinitely_far() -> None:
    nearby = Nearby(ground_of([]))
    assert [nearby.clearance_m(x_m, 0.0) for x_m in (0.0, 0.1, 99.0)] == [math.inf] * 3
