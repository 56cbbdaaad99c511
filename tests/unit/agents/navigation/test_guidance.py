import math
from collections import deque

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.navigation.guidance import CELLS_MAX, PACKED_M, SPOT_KEEPS, CostToGo, Map
from agents.navigation.pricing import COMFORT, DOUBT
from protocol.arrays import Flags, Floats
from protocol.mission import Bounds
from protocol.wire.view import SEEN_BYTES_MAX
from tests.support.stages.one_step import under
from tests.support.strategies.examples import examples

BOUNDS = Bounds(x_m_min=-1.0, y_m_min=-2.0, x_m_max=3.0, y_m_max=1.0)
ROBOT = under("certified", robot_radius_m=0.1, bounds=BOUNDS)
CELL_M = 0.05  # the largest size of a cell
KEEP_M = ROBOT.obstacle_keep_m
KEEP_IN_M = ROBOT.robot_radius_m + ROBOT.mu0_m
DETOUR = 1.083  # worst factor of a way over eight neighbours
GOAL = np.array([2.03, -0.52])
START = np.array([-0.47, -0.52])
WALL_X_M = 1.0

inside = st.tuples(st.floats(-0.8, 2.8), st.floats(-1.8, 0.8))
hits = st.lists(inside, max_size=12).map(lambda found: np.array(found).reshape(-1, 2))


def map_of(hit_points: Floats) -> Map:
    region = Map(ROBOT, START)
    region.remember(hit_points)
    return region


def cost_of(region: Map, goal: Floats = GOAL, *, tolerance_m: float = 0.0) -> CostToGo:
    return region.cost_to_go(goal, tolerance_m=tolerance_m)


def cost_at(cost: CostToGo, at: Floats) -> float:
    return float(cost.at(at[None, :])[0])


def wall(*, door_m: tuple[float, float] | None = None) -> Floats:
    """Hits along x = 1 from side to side, except for a door between two values of y."""
    y_m = np.arange(-2.0, 1.0, CELL_M / 2.0)
    if door_m is not None:
        y_m = y_m[(y_m < door_m[0]) | (y_m > door_m[1])]
    return np.column_stack([np.full(len(y_m), WALL_X_M), y_m])


def centres(cost: CostToGo) -> Floats:
    """The centre of every cell (x, y, 2) [m; world frame]."""
    return np.asarray(
        np.moveaxis(np.indices(cost.cells.shape), 0, -1) * CELL_M + cost.grid.low + CELL_M / 2.0
    )


def off(points: Floats, cost: CostToGo) -> Floats:
    """Distance of the centre of every cell from the nearest of some points (n, 2)."""
    apart_m = np.hypot(*np.moveaxis(centres(cost)[:, :, None, :] - points, -1, 0))
    return np.asarray(apart_m.min(axis=-1, initial=np.inf))


def flooded(is_open: Flags, sources: Flags) -> Flags:
    """All open cells reachable from the sources over eight neighbours, found without a graph."""
    reached = sources & is_open
    waiting = deque(map(tuple, np.argwhere(reached).tolist()))
    while waiting:
        x, y = waiting.popleft()
        for nx, ny in ((x + dx, y + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)):
            on_grid = 0 <= nx < is_open.shape[0] and 0 <= ny < is_open.shape[1]
            if on_grid and is_open[nx, ny] and not reached[nx, ny]:
                reached[nx, ny] = True
                waiting.append((nx, ny))
    return reached


# --- cost-to-go -------------------------------------------------------------------------------------


@given(hits)
@settings(max_examples=examples(20))
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


@given(hits)
@settings(max_examples=examples(20))
def test_the_cost_is_finite_exactly_where_a_flood_from_the_goal_reaches(hit_points: Floats) -> None:
    cost = cost_of(map_of(hit_points))
    middles = centres(cost)
    low, high = np.array([BOUNDS.x_m_min, BOUNDS.y_m_min]), np.array([BOUNDS.x_m_max, BOUNDS.y_m_max])
    off_border = np.minimum(middles - low, high - middles).min(axis=-1) - KEEP_IN_M
    room = np.minimum(off(hit_points, cost) - KEEP_M, off_border)
    at_goal = np.hypot(*np.moveaxis(middles - GOAL, -1, 0)) <= CELL_M
    surely = flooded(room > -CELL_M / 2.0 + 1e-9, at_goal)
    perhaps = flooded(room > -CELL_M / 2.0 - 1e-9, at_goal)
    assert np.isfinite(cost.cells[surely]).all()
    assert np.isinf(cost.cells[~perhaps]).all()


@given(hits, inside)
@settings(max_examples=examples(20))
def test_the_cost_is_never_less_than_the_straight_line(hit_points: Floats, at: tuple[float, float]) -> None:
    # Start and goal may each be a cell away from the cells between which the cost is computed.
    crow_m = math.dist(at, GOAL) - 2.0 * math.sqrt(2.0) * CELL_M
    assert cost_at(cost_of(map_of(hit_points)), np.array(at)) >= crow_m


@given(hits)
@settings(max_examples=examples(20))
def test_cells_too_near_to_a_hit_are_closed_and_those_within_half_a_cell_more_are_costly(
    hit_points: Floats,
) -> None:
    cost = cost_of(map_of(hit_points))
    off_m = off(hit_points, cost)
    assert np.isinf(cost.cells[off_m <= KEEP_M - CELL_M / 2.0 - 1e-9]).all()
    doubtful = np.isfinite(cost.cells) & (off_m < KEEP_M - 1e-9) & (cost.cells > 0.0)
    # A step into or out of such a cell costs at least half the price of the doubt.
    padded = np.pad(cost.cells, 1, constant_values=np.inf)
    width, height = cost.cells.shape
    around = np.min([padded[x : x + width, y : y + height] for x in (0, 1, 2) for y in (0, 1, 2)], axis=0)
    assert (cost.cells[doubtful] - around[doubtful] >= DOUBT * CELL_M / 2.0).all()


@given(hits, inside.map(np.array))
def test_with_an_origin_all_cells_that_cost_no_more_than_it_have_their_cost(
    hit_points: Floats, origin: Floats
) -> None:
    region = map_of(hit_points)
    everywhere, asked = cost_of(region), region.cost_to_go(GOAL, tolerance_m=0.0, origin=origin)
    there_m = cost_at(everywhere, origin)
    assert cost_at(asked, origin) == there_m
    near = everywhere.cells <= there_m
    assert (asked.cells[near] == everywhere.cells[near]).all()
    assert (np.isinf(asked.cells) | (asked.cells == everywhere.cells)).all()


def test_with_an_origin_even_a_very_long_detour_is_found() -> None:
    region = map_of(wall(door_m=(0.3, 0.8)))
    origin = np.array([0.6, -1.5])
    cost_m = cost_at(region.cost_to_go(np.array([1.4, -1.5]), tolerance_m=0.0, origin=origin), origin)
    assert 3.5 < cost_m < math.inf


def test_unseen_ground_is_free() -> None:
    cost = cost_of(map_of(np.empty((0, 2))))
    assert cost_at(cost, GOAL) == pytest.approx(0.0, abs=2.0 * CELL_M)
    assert cost_at(cost, START) == pytest.approx(math.dist(START, GOAL), abs=2.0 * CELL_M)


@given(st.tuples(st.floats(-0.3, 2.3), st.floats(-1.3, 0.3)))
@settings(max_examples=examples(20))
def test_in_the_open_a_way_is_hardly_longer_than_the_straight_line(at: tuple[float, float]) -> None:
    assert cost_at(cost_of(map_of(np.empty((0, 2)))), np.array(at)) <= DETOUR * math.dist(at, GOAL) + CELL_M


def test_the_way_through_a_wall_leads_through_its_door() -> None:
    door = np.array([WALL_X_M, 0.25])
    cost = cost_of(map_of(wall(door_m=(-0.3, 0.8))))
    by_the_door_m = math.dist(START, door) + math.dist(door, GOAL)
    # Cells next to the door's posts cost more.
    assert by_the_door_m * 0.9 <= cost_at(cost, START) <= by_the_door_m * DETOUR + COMFORT * 8.0 * CELL_M
    assert cost_at(cost, START) > math.dist(START, GOAL) + 0.2
    assert cost_at(cost, door) < cost_at(cost, START)


def test_a_door_too_narrow_for_the_robot_is_no_way() -> None:
    assert cost_at(cost_of(map_of(wall(door_m=(-0.15, 0.15)))), START) == math.inf


def test_a_way_prefers_a_wide_door_some_metres_off_to_a_doubtful_one() -> None:
    closed = wall()
    doubtful, wide = np.abs(closed[:, 1] + 0.5) < KEEP_M - CELL_M / 4.0, closed[:, 1] > 0.2
    cost = cost_of(map_of(closed[~doubtful & ~wide]))
    assert cost_at(cost, np.array([WALL_X_M, 0.6])) < cost_at(cost, START) < math.inf
    way = cost.way_from(START, cells_max=1000)
    assert way[np.abs(way[:, 0] - WALL_X_M) < CELL_M][:, 1].min() > 0.2


def test_a_wall_without_a_door_leaves_no_way() -> None:
    cost = cost_of(map_of(wall()))
    assert cost_at(cost, START) == math.inf
    assert cost_at(cost, GOAL + np.array([0.3, 0.0])) < 1.0
    assert len(cost.way_from(START, cells_max=1000)) == 0


@given(hits)
@settings(max_examples=examples(20))
def test_the_way_leads_from_cell_to_cell_down_to_the_goal(hit_points: Floats) -> None:
    cost = cost_of(map_of(hit_points))
    way = cost.way_from(START, cells_max=10_000)
    if len(way):
        assert np.hypot(*(way[0] - START)) <= 2.0 * math.sqrt(2.0) * CELL_M
        assert np.hypot(*(way[-1] - GOAL)) <= CELL_M
        assert (np.hypot(*np.diff(way, axis=0).T) <= math.sqrt(2.0) * CELL_M + 1e-9).all()
    else:
        assert cost_at(cost, START) == math.inf


# --- memory -----------------------------------------------------------------------------------------


def test_a_hit_seen_once_is_remembered() -> None:
    region, both = map_of(wall(door_m=(0.0, 3.0))), wall()
    before = cost_at(cost_of(region), START)
    region.remember(both[both[:, 1] >= -0.1])
    region.remember(np.empty((0, 2)))
    assert math.isfinite(before)
    assert cost_at(cost_of(region), START) == math.inf


@given(st.lists(hits, min_size=2, max_size=4))
@settings(max_examples=examples(20))
def test_the_map_does_not_depend_on_how_hits_are_split_into_scans_or_repeated(scans: list[Floats]) -> None:
    whole, bit_by_bit = map_of(np.concatenate(scans)), map_of(scans[0])
    for scan in [*scans[1:], scans[0]]:
        bit_by_bit.remember(scan)
    one, other = cost_of(whole).cells, cost_of(bit_by_bit).cells
    # Two hits in one part of a cell count as one; the result may differ by the size of that part.
    differ = np.isfinite(one) != np.isfinite(other)
    near_m = np.abs(off(np.concatenate(scans), cost_of(whole)) - (KEEP_M - CELL_M / 2.0))
    reached_otherwise = near_m.min(initial=np.inf, where=differ) <= CELL_M / 2.0
    assert reached_otherwise or not differ.any()


def test_hits_outside_the_bounds_are_ignored() -> None:
    outside = np.array([[-1.05, 0.0], [3.0, 0.0], [0.0, 1.0], [0.0, -2.05], [99.0, 99.0], [-99.0, 0.0]])
    assert cost_of(map_of(outside)).cells.tolist() == cost_of(map_of(np.empty((0, 2)))).cells.tolist()


def test_the_hull_stays_inside_the_bounds() -> None:
    cost = cost_of(map_of(np.empty((0, 2))))
    open_to = centres(cost)[np.isfinite(cost.cells)]
    # A doubtful cell is open: at most half a cell off.
    low, high = np.array([-1.0, -2.0]) + KEEP_IN_M, np.array([3.0, 1.0]) - KEEP_IN_M
    assert (np.abs(open_to.min(axis=0) - low) <= CELL_M / 2.0 + 1e-9).all()
    assert (np.abs(open_to.max(axis=0) - high) <= CELL_M / 2.0 + 1e-9).all()


def test_outside_the_bounds_there_is_no_way() -> None:
    cost = cost_of(map_of(np.empty((0, 2))))
    outside = np.array([[-1.2, 0.0], [3.2, 0.0], [0.0, 1.2], [0.0, -2.2]])
    assert cost.at(outside).tolist() == [math.inf] * 4


def test_if_the_goal_is_closed_an_open_place_within_its_tolerance_is_enough() -> None:
    region = map_of(GOAL[None, :])
    strict, tolerant = cost_of(region), cost_of(region, tolerance_m=0.4)
    assert cost_at(strict, START) == math.inf
    assert cost_at(tolerant, START) == pytest.approx(math.dist(START, GOAL) - 0.4, abs=3.0 * CELL_M)
    reached = centres(tolerant)[tolerant.cells == 0.0]
    assert (np.hypot(*(reached - GOAL).T) <= 0.4).all()


def test_if_the_goal_is_open_the_way_leads_all_the_way_to_it() -> None:
    region = map_of(np.empty((0, 2)))
    assert cost_of(region, tolerance_m=0.5).cells.tolist() == cost_of(region).cells.tolist()


def test_a_way_keeps_off_obstacles_where_there_is_room() -> None:
    post = np.array([[0.75, -0.55]])
    cost = cost_of(map_of(post))
    beside = np.array([0.75, -0.55 + KEEP_M + CELL_M])
    aside = beside + np.array([0.0, 2.0 * CELL_M])
    assert math.isfinite(cost_at(cost, beside))
    assert cost_at(cost, aside) < cost_at(cost, beside)


def test_a_large_region_gets_larger_cells_not_more_cells() -> None:
    wide = under("certified", bounds=Bounds(x_m_min=0.0, y_m_min=0.0, x_m_max=100.0, y_m_max=50.0))
    cost = Map(wide, START).cost_to_go(np.array([90.0, 25.0]), tolerance_m=0.0)
    assert cost.cells.size <= 1.01 * CELLS_MAX  # the last row and column may overlap
    assert cost_at(cost, np.array([10.0, 25.0])) == pytest.approx(80.0, abs=1.0)


# --- closed spots, taken ground ---------------------------------------------------------------------


def test_a_closed_spot_stays_closed_and_the_way_avoids_it() -> None:
    region = map_of(wall(door_m=(-0.3, 0.8)))
    narrow = np.array([WALL_X_M, 0.25])
    before = cost_at(cost_of(region), narrow)
    region.close(narrow)
    region.remember(wall(door_m=(-0.3, 0.8)))
    closed = cost_of(region)
    assert math.isfinite(before)
    off_m = np.hypot(*np.moveaxis(centres(closed) - narrow, -1, 0))
    assert np.isinf(closed.cells[off_m <= SPOT_KEEPS * KEEP_M - CELL_M / 2.0 - 1e-9]).all()
    assert np.isfinite(closed.cells[np.abs(off_m - SPOT_KEEPS * KEEP_M - CELL_M) < CELL_M / 2.0]).any()


def test_the_narrowest_spot_of_a_way_is_in_the_door() -> None:
    region = map_of(wall(door_m=(0.0, 0.6)))
    spot = region.narrowest(cost_of(region).way_from(START, cells_max=1000))
    assert abs(spot[0] - WALL_X_M) <= CELL_M
    assert 0.0 < spot[1] < 0.6


@given(st.floats(-0.9, 2.9), st.floats(2.0 * CELL_M, 0.6))
@settings(max_examples=examples(20))
def test_ground_of_other_robots_is_closed_up_to_the_distance_to_keep(x_m: float, keep_m: float) -> None:
    region = map_of(np.empty((0, 2)))
    taken = np.array([[x_m, -2.0], [x_m, -1.0], [x_m, 1.0]])
    cost = region.cost_to_go(GOAL, tolerance_m=0.0, taken=taken, keep_m=keep_m)
    off_m = np.abs(centres(cost)[..., 0] - x_m)
    assert np.isinf(cost.cells[off_m <= keep_m - CELL_M / 2.0 - 1e-9]).all()
    other_side = (centres(cost)[..., 0] - x_m) * (GOAL[0] - x_m) < 0.0
    assert np.isinf(cost.cells[other_side]).all()
    again = region.cost_to_go(GOAL, tolerance_m=0.0)
    assert again.cells.tolist() == cost_of(map_of(np.empty((0, 2)))).cells.tolist(), (
        "taken ground is not remembered"
    )


# --- where there are no bounds ----------------------------------------------------------------------


@given(st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=1, max_size=5))
@settings(max_examples=examples(20))
def test_without_bounds_the_grid_grows_and_forgets_nothing(
    seen: list[tuple[float, float]],
) -> None:
    region = Map(under("certified", robot_radius_m=0.1), START)
    points = np.array(seen)
    for point in points:
        region.remember(point[None])
    cost = region.cost_to_go(np.array([12.0, 0.0]), tolerance_m=0.0)
    assert cost.grid.has(np.append(points, [[12.0, 0.0]], axis=0)).all()
    for point in points:
        assert cost_at(cost, point) == math.inf
    off_m = np.hypot(*(points - START).T).min()
    assert math.isfinite(cost_at(cost, START)) or off_m < KEEP_M + 2.0 * cost.grid.cell_m


def test_without_bounds_a_way_can_lead_around_what_has_been_seen() -> None:
    region = Map(under("certified", robot_radius_m=0.1), START)
    region.remember(wall())
    assert cost_at(cost_of(region), START) > math.dist(START, GOAL) + 1.0
    assert math.isfinite(cost_at(cost_of(region), START))


# --- handed over ------------------------------------------------------------------------------------


@given(st.lists(inside, max_size=60).map(lambda found: np.array(found).reshape(-1, 2)))
@settings(max_examples=examples(20))
def test_a_map_that_was_handed_over_closes_the_same_ground_up_to_rounding(hit_points: Floats) -> None:
    successor = map_of(np.empty((0, 2)))
    successor.unpack(map_of(hit_points).packed())
    cost = cost_of(successor)
    off_m = off(hit_points, cost)
    # One of two hits within a part of a cell is kept.
    rounding_m = PACKED_M + math.sqrt(2.0) * CELL_M / 4.0
    assert np.isinf(cost.cells[off_m <= KEEP_M - CELL_M / 2.0 - rounding_m]).all()
    reached = np.isfinite(cost.cells)
    assert (off_m[reached] > KEEP_M - CELL_M / 2.0 - rounding_m).all()


def test_a_hand_over_contains_all_hits_to_five_millimetres() -> None:
    region = map_of(wall(door_m=(-0.3, 0.8)))
    successor = map_of(np.empty((0, 2)))
    successor.unpack(region.packed())
    again = map_of(np.empty((0, 2)))
    again.unpack(successor.packed())
    assert again.packed() == successor.packed() == region.packed()
    assert cost_at(cost_of(successor), START) == pytest.approx(cost_at(cost_of(region), START), abs=CELL_M)


def test_a_map_too_large_for_a_message_is_thinned_evenly() -> None:
    chance = np.random.default_rng(1)
    region = Map(under("certified", robot_radius_m=0.1), START)
    region.remember(chance.uniform(-10.0, 10.0, (60_000, 2)))
    packed = region.packed()
    assert len(packed) <= SEEN_BYTES_MAX
    assert len(packed) > SEEN_BYTES_MAX / 4


@given(st.binary(max_size=300))
@settings(max_examples=examples(25))
def test_invalid_packed_data_changes_nothing(packed: bytes) -> None:
    region, untouched = map_of(wall(door_m=(-0.3, 0.8))), map_of(wall(door_m=(-0.3, 0.8)))
    region.unpack(packed)
    assert region.packed() == untouched.packed()
