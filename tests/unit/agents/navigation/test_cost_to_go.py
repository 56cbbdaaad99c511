import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.grid import Grid
from agents.navigation.guidance import CostToGo
from protocol.arrays import Floats

GRID = Grid(np.array([-1.0, -0.5]), (6, 4), 0.5)

cells = st.lists(
    st.one_of(st.just(math.inf), st.integers(0, 90).map(lambda tenths: tenths / 10.0)),
    min_size=24,
    max_size=24,
).map(lambda costs: np.array(costs).reshape(GRID.shape))
# A raster without cell centres, so that the four cells around are unambiguous.
places = st.tuples(st.integers(-40, 60), st.integers(-40, 60)).map(
    lambda place: np.array([place[0] * 0.07 + 0.011, place[1] * 0.07 + 0.013])
)


@given(cells, st.lists(places, min_size=1, max_size=20))
def test_the_cost_at_a_point_is_over_the_best_of_the_four_cells_around(
    costs: Floats, points: list[Floats]
) -> None:
    found = CostToGo(GRID, costs).at(np.array(points))
    middles = GRID.centres_of(np.moveaxis(np.indices(GRID.shape), 0, -1))
    for point, cost in zip(points, found, strict=True):
        around = (np.abs(middles - point) < GRID.cell_m).all(axis=-1)
        by_way_of = costs + np.hypot(*np.moveaxis(middles - point, -1, 0))
        assert cost == pytest.approx(by_way_of[around].min(initial=math.inf))
