"""What a map keeps from plan to plan, or gives up between them, changes no cost."""

from collections.abc import Callable
from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.grid import Lattice
from agents.navigation.guidance import Map
from agents.navigation.pricing import Cells
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


def map_of(hit_points: Floats) -> Map:
    region = Map(ROBOT, GOAL)
    region.remember(hit_points)
    return region


def cells_of(region: Map) -> Floats:
    """What its cells cost."""
    return region.cost_to_go(GOAL, tolerance_m=0.0).cells


@given(hits, inside)
def test_a_map_that_was_released_tells_the_same_costs(hit_points: Floats, spot: tuple[float, float]) -> None:
    region = map_of(hit_points)
    region.close(np.array(spot))
    before = cells_of(region)
    region.release()
    np.testing.assert_array_equal(cells_of(region), before)


@given(hits, hits)
def test_a_map_that_was_released_remembers_what_it_sees_next(first: Floats, then: Floats) -> None:
    released, kept = map_of(first), map_of(first)
    released.release()
    for region in (released, kept):
        region.remember(then)
        region.remember(first)
    np.testing.assert_array_equal(released.hits, kept.hits)
    np.testing.assert_array_equal(cells_of(released), cells_of(kept))


def test_a_map_has_no_cells_until_it_is_used_and_none_after_its_release(
    held: Callable[[type], list[Any]],
) -> None:
    region = Map(ROBOT, GOAL)
    assert held(Cells) == []
    cells_of(region)
    assert (len(held(Cells)), len(held(Lattice))) == (1, 1)
    region.release()
    assert (held(Cells), held(Lattice)) == ([], [])


def test_an_extended_map_is_a_copy_that_shares_the_lattice(held: Callable[[type], list[Any]]) -> None:
    region = map_of(np.array([[1.0, 0.0]]))
    before = cells_of(region)
    other = region.extended(np.array([[0.0, -1.0]]))
    assert len(held(Lattice)) == 1
    assert len(other.hits) == len(region.hits) + 1
    assert (cells_of(other) > before).any()
    np.testing.assert_array_equal(cells_of(region), before)
