"""What it costs to drive through cells, and from them to a goal: the same, however the costs came about."""

import copy

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.grid import Grid
from agents.navigation.pricing import COST_M_MAX, Flood, Pricing
from protocol.arrays import Floats, Indices

CELL_M = 0.1
SHAPE = (6, 5)
OF = Grid(np.array([-1.0, -0.5]), SHAPE, CELL_M)
GOAL = np.array([7])
rooms = st.lists(st.sampled_from([-0.2, -0.03, 0.1, 0.25, np.inf]), min_size=30, max_size=30)
changes = st.lists(st.tuples(st.integers(0, 29), st.sampled_from([-0.2, 0.1, np.inf])), max_size=12)
limits_m = st.one_of(st.floats(0.0, 3.0), st.just(COST_M_MAX))


def costs_of(room: Floats) -> Floats:
    """The costs of all edges, computed at once."""
    costs = np.full((30, 8), np.inf)
    Pricing(OF).update(costs, room)
    return costs


def all_m(room: Floats, sources: Indices) -> Floats:
    """The costs of all cells, computed at once."""
    new = Flood(OF)
    new.begin(room, sources)
    return new.alone(sources)


@given(rooms, st.lists(changes, max_size=3))
def test_costs_after_changes_are_those_of_a_new_pricing(
    room: list[float], later: list[list[tuple[int, float]]]
) -> None:
    pricing, costs, now = Pricing(OF), np.full((30, 8), np.inf), np.array(room)
    pricing.update(costs, now.reshape(SHAPE))
    for each in later:
        before = costs.copy()
        for cell, value in each:
            now[cell] = value
        changed = pricing.update(costs, now.reshape(SHAPE))
        assert (costs == costs_of(now)).all()
        assert len(changed) > 0 or (costs == before).all()


def test_a_pricing_keeps_no_reference_to_the_room() -> None:
    pricing, costs, room = Pricing(OF), np.full((30, 8), np.inf), np.full(SHAPE, np.inf)
    pricing.update(costs, room)
    room[2, 2] = -1.0
    pricing.update(costs, room)
    assert np.isinf(costs).sum() > np.isinf(costs_of(np.full(SHAPE, np.inf))).sum()


@given(
    rooms, st.lists(st.tuples(changes, st.lists(limits_m, min_size=1, max_size=3)), min_size=2, max_size=4)
)
def test_a_flood_that_goes_on_after_changes_has_the_costs_of_a_new_one(
    room: list[float], plans: list[tuple[list[tuple[int, float]], list[float]]]
) -> None:
    flood, now = Flood(OF), np.array(room)
    for each, limits in plans:
        for cell, value in each:
            now[cell] = value
        now[GOAL] = np.inf
        flood.begin(now.reshape(SHAPE), GOAL)
        expected_m = all_m(now, GOAL)
        for limit_m in limits:
            found_m = flood.up_to(limit_m)
            near = expected_m <= min(max(limit_m, flood.reached_m), COST_M_MAX)
            assert (found_m[near] == expected_m[near]).all()
            assert (np.isinf(found_m) | (found_m == expected_m)).all()


@given(st.integers(0, 29), st.integers(0, 29))
def test_a_flood_from_other_cells_keeps_nothing(one: int, other: int) -> None:
    flood, room = Flood(OF), np.full(SHAPE, np.inf)
    for cell in (one, other):
        flood.begin(room, np.array([cell]))
        assert (flood.up_to(COST_M_MAX) == all_m(room, np.array([cell]))).all()


def test_costs_that_were_told_stay_when_the_flood_goes_on() -> None:
    flood, room = Flood(OF), np.full(SHAPE, np.inf)
    flood.begin(room, GOAL)
    told_m = flood.up_to(0.2)
    before_m = told_m.copy()
    room[3, 3] = -1.0
    flood.begin(room, GOAL)
    flood.up_to(COST_M_MAX)
    assert (told_m == before_m).all()


def test_a_copy_of_a_flood_goes_on_alone() -> None:
    flood, room = Flood(OF), np.full(SHAPE, np.inf)
    flood.begin(room, GOAL)
    flood.up_to(0.2)
    other = copy.deepcopy(flood)
    room[3, 3] = -1.0
    other.begin(room, GOAL)
    assert (other.up_to(COST_M_MAX) == all_m(room, GOAL)).all()
