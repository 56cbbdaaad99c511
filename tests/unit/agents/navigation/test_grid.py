import math
from itertools import permutations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from agents.navigation.grid import FINE, Grid, Lattice
from protocol.arrays import Floats
from tests.support.strategies.examples import examples

CELL_M = 0.1
LOW = np.array([-1.0, -0.5])
HIGH = np.array([1.0, 1.0])
ROUNDING_M = 1e-9

# In millimetres: shapely divides by the square of a length, which must not be tiny.
around = st.tuples(st.integers(-1600, 1600), st.integers(-1100, 1600)).map(
    lambda place: (place[0] / 1000.0, place[1] / 1000.0)
)
points_around = st.lists(around, min_size=1, max_size=6).map(lambda found: np.array(found).reshape(-1, 2))
reaches_m = st.floats(0.05, 0.6)


def grid() -> Grid:
    return Grid.over(LOW, HIGH, CELL_M, cells_max=10_000)


def centres(of: Grid) -> Floats:
    """The centre of every cell (x, y, 2)."""
    return of.centres_of(np.moveaxis(np.indices(of.shape), 0, -1))


@given(st.floats(0.1, 300.0), st.floats(0.1, 300.0), st.floats(0.01, 0.5))
def test_a_grid_covers_its_rectangle_within_the_limit_of_cells(
    width_m: float, height_m: float, cell_m: float
) -> None:
    high = LOW + np.array([width_m, height_m])
    covering = Grid.over(LOW, high, cell_m, cells_max=5000)
    assert (covering.high >= high - ROUNDING_M * np.abs(high)).all()
    assert covering.cell_m >= cell_m
    # The last row and column may overlap; a rectangle thinner than a cell has one row.
    most = 5000 + sum(covering.shape) + 1
    assert math.prod(covering.shape) <= most


@given(points_around)
def test_a_point_is_in_the_cell_whose_centre_is_nearest(points: Floats) -> None:
    of = grid()
    off = np.abs(of.centres_of(of.cells_of(points)) - points)
    assert (off <= CELL_M / 2.0 + ROUNDING_M).all()
    on_it = ((points >= LOW) & (points < of.high)).all(axis=1)
    assert of.has(points).tolist() == on_it.tolist()


@given(points_around, reaches_m, st.floats(0.0, 0.3))
def test_room_never_exceeds_the_distance_to_a_point_and_is_exact_within_reach(
    points: Floats, reach_m: float, less_m: float
) -> None:
    of = grid()
    points, room = points[of.has(points)], np.full(of.shape, np.inf)
    of.lower_around(room, points, reach_m=reach_m, less_m=less_m)
    off_m = np.hypot(*np.moveaxis(centres(of)[:, :, None] - points, -1, 0)).min(axis=-1, initial=np.inf)
    near = off_m <= reach_m
    assert room[near] == pytest.approx(off_m[near] - less_m, abs=ROUNDING_M)
    assert (room >= off_m - less_m - ROUNDING_M).all()


@given(points_around, points_around, reaches_m)
def test_room_only_shrinks_and_does_not_depend_on_the_order_of_points(
    one: Floats, other: Floats, reach_m: float
) -> None:
    of = grid()
    one, other = one[of.has(one)], other[of.has(other)]
    there, back = np.full(of.shape, np.inf), np.full(of.shape, np.inf)
    of.lower_around(there, one, reach_m=reach_m, less_m=0.0)
    before = there.copy()
    of.lower_around(there, other, reach_m=reach_m, less_m=0.0)
    of.lower_around(back, np.concatenate([other, one]), reach_m=reach_m, less_m=0.0)
    assert (there <= before).all()
    assert there.tolist() == back.tolist()


def test_without_points_room_does_not_change() -> None:
    of = grid()
    room = np.full(of.shape, np.inf)
    of.lower_around(room, np.empty((0, 2)), reach_m=0.5, less_m=0.0)
    assert np.isinf(room).all()


@given(st.lists(around, min_size=2, max_size=6), reaches_m)
def test_the_distance_off_a_line_agrees_with_shapely_within_reach(
    corners: list[tuple[float, float]], reach_m: float
) -> None:
    of, found_m = grid(), np.full(grid().shape, np.inf)
    of.lower_along(found_m, np.array(corners), reach_m=reach_m, less_m=0.0)
    line, cells = shapely.LineString(corners), centres(of)
    expected_m = shapely.distance(line, shapely.points(cells[..., 0], cells[..., 1]))
    near = expected_m <= reach_m
    assert found_m[near] == pytest.approx(expected_m[near], abs=1e-7)
    assert (found_m[~near] >= expected_m[~near] - 1e-7).all()


def test_the_distance_off_the_border_is_that_of_the_nearest_side() -> None:
    of = grid()
    cells = centres(of)
    expected_m = np.minimum(cells - of.low, of.high - cells).min(axis=-1)
    assert of.off_border() == pytest.approx(expected_m)


def priced(of: Grid, price: Floats) -> csr_array:
    costs = np.empty((price.size, 8))
    Lattice.of(of).price(costs, price.reshape(-1))
    return Lattice.of(of).graph(costs)


@given(st.lists(st.booleans(), min_size=30, max_size=30))
def test_open_cells_are_joined_exactly_to_their_open_neighbours(open_or_not: list[bool]) -> None:
    of = Grid(LOW, (6, 5), CELL_M)
    is_open = np.array(open_or_not).reshape(of.shape)
    graph = priced(of, np.where(is_open, 2.0, np.inf)).toarray()
    for one, other in permutations(np.ndindex(of.shape), 2):
        apart = np.abs(np.subtract(one, other))
        joined = apart.max() == 1 and is_open[one] and is_open[other]
        found = graph[np.ravel_multi_index(one, of.shape), np.ravel_multi_index(other, of.shape)]
        assert (0.0 < found < math.inf) == joined
        assert not joined or found == pytest.approx(2.0 * CELL_M * math.hypot(*apart))


def test_a_step_between_two_cells_costs_the_mean_of_their_prices() -> None:
    of = Grid(LOW, (2, 1), CELL_M)
    cost_m = dijkstra(priced(of, np.array([[1.0], [4.0]])))
    assert cost_m == pytest.approx(np.array([[0.0, 2.5 * CELL_M], [2.5 * CELL_M, 0.0]]))


def test_a_grid_without_walls_is_one_piece() -> None:
    of = grid()
    graph = priced(of, np.ones(of.shape))
    assert connected_components(graph, directed=False)[0] == 1


@given(points_around)
@settings(max_examples=examples(50))
def test_two_points_have_the_same_number_exactly_if_they_share_a_fine_part(points: Floats) -> None:
    of = grid()
    on_it = points[of.has(points)]
    numbers = of.fine_parts(on_it)
    parts = np.floor((on_it - of.low) / of.cell_m * FINE)
    same = (parts[:, None] == parts[None]).all(axis=-1)
    assert ((numbers[:, None] == numbers[None]) == same).all()
