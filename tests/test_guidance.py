import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.guidance import CELLS_MAX, COMFORT, CostToGo, Map
from protocol.arrays import Floats
from protocol.mission import Bounds

BOUNDS = Bounds(x_m_min=-1.0, y_m_min=-2.0, x_m_max=3.0, y_m_max=1.0)
CELL_M = 0.1
KEEP_M = 0.2
KEEP_IN_M = 0.1
GOAL = np.array([2.03, -0.52])
START = np.array([-0.47, -0.52])
WALL_X_M = 1.0

inside = st.tuples(st.floats(-0.8, 2.8), st.floats(-1.8, 0.8))
hits = st.lists(inside, max_size=12).map(lambda found: np.array(found).reshape(-1, 2))


def map_of(hit_points: Floats) -> Map:
    region = Map(BOUNDS, cell_m=CELL_M)
    region.remember(hit_points)
    return region


def cost_of(region: Map, goal: Floats = GOAL, *, tolerance_m: float = 0.0) -> CostToGo:
    return region.cost_to_go(goal, tolerance_m=tolerance_m, keep_m=KEEP_M, keep_in_m=KEEP_IN_M)


def cost_at(cost: CostToGo, at: Floats) -> float:
    return float(cost.at(at[None, :])[0])


def wall(*, door_m: tuple[float, float] | None = None) -> Floats:
    """Hits all along x = 1 from side to side, but for a door between two values of y."""
    y_m = np.arange(-2.0, 1.0, CELL_M / 2.0)
    if door_m is not None:
        y_m = y_m[(y_m < door_m[0]) | (y_m > door_m[1])]
    return np.column_stack([np.full(len(y_m), WALL_X_M), y_m])


def centres(cost: CostToGo) -> Floats:
    """The middle of every cell (x, y, 2) [m; world frame]."""
    return np.moveaxis(np.indices(cost.cells.shape), 0, -1) * cost.cell_m + cost.low + cost.cell_m / 2.0


@given(hits)
@settings(max_examples=50)
def test_from_every_open_cell_a_neighbour_leads_down_to_the_goal(hit_points: Floats) -> None:
    cost = cost_of(map_of(hit_points))
    padded = np.pad(cost.cells, 1, constant_values=np.inf)
    width, height = cost.cells.shape
    steps = [(dx, dy) for dx in (0, 1, 2) for dy in (0, 1, 2) if (dx, dy) != (1, 1)]
    around = np.min([padded[dx : dx + width, dy : dy + height] for dx, dy in steps], axis=0)
    on_the_way = np.isfinite(cost.cells) & (cost.cells > 0.0)
    assert (around[on_the_way] <= cost.cells[on_the_way] - CELL_M * (1.0 - 1e-9)).all()
    at_goal = centres(cost)[cost.cells == 0.0]
    assert (np.hypot(*(at_goal - GOAL).T) <= CELL_M).all()


@given(hits, inside)
@settings(max_examples=50)
def test_the_cost_is_never_less_than_the_way_as_the_crow_flies(
    hit_points: Floats, at: tuple[float, float]
) -> None:
    # The start is a cell off those it is reckoned from, and the goal off those where the cost is nothing.
    crow_m = math.dist(at, GOAL) - 2.0 * math.sqrt(2.0) * CELL_M
    assert cost_at(cost_of(map_of(hit_points)), np.array(at)) >= crow_m


@given(hits)
@settings(max_examples=50)
def test_cells_nearer_to_a_hit_than_the_robot_may_come_are_closed_and_no_others(hit_points: Floats) -> None:
    cost = cost_of(map_of(hit_points))
    cells = np.floor((hit_points - cost.low) / CELL_M) * CELL_M + cost.low + CELL_M / 2.0
    off_m = np.hypot(*np.moveaxis(centres(cost)[:, :, None, :] - cells, -1, 0)).min(axis=-1, initial=np.inf)
    assert np.isinf(cost.cells[off_m < KEEP_M - 1e-9]).all()
    reached = np.isfinite(cost.cells)
    assert (off_m[reached] > KEEP_M - 1e-9).all()


def test_ground_that_nobody_has_seen_is_free() -> None:
    cost = cost_of(Map(BOUNDS, cell_m=CELL_M))
    assert cost_at(cost, GOAL) == pytest.approx(0.0, abs=2.0 * CELL_M)
    assert cost_at(cost, START) == pytest.approx(math.dist(START, GOAL), abs=2.0 * CELL_M)


@given(st.tuples(st.floats(-0.3, 2.3), st.floats(-1.3, 0.3)))
def test_in_the_open_a_way_is_hardly_longer_than_the_crow_flies(at: tuple[float, float]) -> None:
    cost = cost_at(cost_of(Map(BOUNDS, cell_m=CELL_M)), np.array(at))
    assert cost <= 1.083 * math.dist(at, GOAL) + CELL_M  # what eight neighbours cost at worst


def test_the_way_through_a_wall_leads_through_its_door() -> None:
    door = np.array([WALL_X_M, 0.25])
    cost = cost_of(map_of(wall(door_m=(-0.3, 0.8))))
    by_the_door_m = math.dist(START, door) + math.dist(door, GOAL)
    # Eight neighbours make a way up to 8.3 % longer, and the door's posts make its last cells dearer.
    assert by_the_door_m * 0.9 <= cost_at(cost, START) <= by_the_door_m * 1.083 + COMFORT * 8.0 * CELL_M
    assert cost_at(cost, START) > math.dist(START, GOAL) + 0.2
    assert cost_at(cost, door) < cost_at(cost, START)


def test_a_door_too_narrow_for_the_robot_is_no_way() -> None:
    assert cost_at(cost_of(map_of(wall(door_m=(-0.1, 0.1)))), START) == math.inf


def test_behind_a_wall_without_a_door_there_is_no_way() -> None:
    cost = cost_of(map_of(wall()))
    assert cost_at(cost, START) == math.inf
    assert cost_at(cost, GOAL + np.array([0.3, 0.0])) < 1.0


def test_what_was_seen_once_is_remembered() -> None:
    region, both = map_of(wall(door_m=(0.0, 3.0))), wall()
    before = cost_at(cost_of(region), START)
    region.remember(both[both[:, 1] >= -0.1])
    region.remember(np.empty((0, 2)))
    assert math.isfinite(before)
    assert cost_at(cost_of(region), START) == math.inf


def test_hits_outside_the_bounds_are_no_concern() -> None:
    outside = np.array([[-1.05, 0.0], [3.0, 0.0], [0.0, 1.0], [0.0, -2.05], [99.0, 99.0], [-99.0, 0.0]])
    region = map_of(outside)
    assert cost_of(region).cells.tolist() == cost_of(Map(BOUNDS, cell_m=CELL_M)).cells.tolist()


def test_the_hull_stays_inside_the_bounds() -> None:
    cost = Map(BOUNDS, cell_m=CELL_M).cost_to_go(GOAL, tolerance_m=0.0, keep_m=KEEP_M, keep_in_m=0.3)
    low, high = (
        centres(cost)[np.isfinite(cost.cells)].min(axis=0),
        centres(cost)[np.isfinite(cost.cells)].max(axis=0),
    )
    assert low.tolist() == pytest.approx([-1.0 + 0.35, -2.0 + 0.35])
    assert high.tolist() == pytest.approx([3.0 - 0.35, 1.0 - 0.35])


def test_outside_the_bounds_there_is_no_way() -> None:
    cost = cost_of(Map(BOUNDS, cell_m=CELL_M))
    outside = np.array([[-1.2, 0.0], [3.2, 0.0], [0.0, 1.2], [0.0, -2.2]])
    assert cost.at(outside).tolist() == [math.inf] * 4


def test_where_the_goal_is_closed_an_open_place_within_its_tolerance_will_do() -> None:
    region = map_of(GOAL[None, :])
    strict, tolerant = cost_of(region), cost_of(region, tolerance_m=0.4)
    assert cost_at(strict, START) == math.inf
    assert cost_at(tolerant, START) == pytest.approx(math.dist(START, GOAL) - 0.4, abs=3.0 * CELL_M)
    reached = centres(tolerant)[tolerant.cells == 0.0]
    assert (np.hypot(*(reached - GOAL).T) <= 0.4).all()


def test_where_the_goal_is_open_its_tolerance_does_not_end_the_way_before_it() -> None:
    region = Map(BOUNDS, cell_m=CELL_M)
    assert cost_of(region, tolerance_m=0.5).cells.tolist() == cost_of(region).cells.tolist()


def test_a_way_keeps_off_obstacles_where_there_is_room() -> None:
    post = np.array([[0.75, -0.55]])
    cost = cost_of(map_of(post))
    beside = np.array([0.75, -0.55 + KEEP_M + CELL_M])
    aside = beside + np.array([0.0, 2.0 * CELL_M])
    assert math.isfinite(cost_at(cost, beside))
    assert cost_at(cost, aside) < cost_at(cost, beside)


def test_a_large_region_gets_larger_cells_instead_of_more() -> None:
    wide = Bounds(x_m_min=0.0, y_m_min=0.0, x_m_max=100.0, y_m_max=50.0)
    cost = Map(wide, cell_m=0.05).cost_to_go(
        np.array([90.0, 25.0]), tolerance_m=0.0, keep_m=KEEP_M, keep_in_m=KEEP_IN_M
    )
    assert cost.cells.size <= 1.01 * CELLS_MAX  # the last row and column may stick out
    assert cost_at(cost, np.array([10.0, 25.0])) == pytest.approx(80.0, abs=1.0)
