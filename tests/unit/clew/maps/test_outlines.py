"""The polygons of a map cover its blocked cells and nothing else, and the loader takes each."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from clew.maps.outlines import CORNERS_MAX, coarsened, outlines, pieces_min
from protocol.arrays import Flags
from tests.support.strategies.examples import examples
from world.geometry.clearance import distances
from world.geometry.shapes import Polygon, ground_of

grids = arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9)))


def check(blocked: Flags) -> None:
    """Corners are corners of cells and edges lie between cells, so a cell is covered where its centre is."""
    rings = outlines(blocked)
    for ring in rings:
        assert (ring == np.round(ring)).all()
        assert ((np.roll(ring, -1, axis=0) == ring).sum(axis=1) == 1).all()
        assert len(ring) <= CORNERS_MAX
    shapes = [Polygon(vertices_m=tuple(map(tuple, ring.tolist()))) for ring in rings]
    assert min((shape.smallest_width_m for shape in shapes), default=1.0) >= 1.0
    ground = ground_of(shapes)
    for y, x in np.ndindex(*blocked.shape):
        inside = distances(ground, np.array((x + 0.5, y + 0.5))).min(initial=np.inf) == 0.0
        assert inside == blocked[y, x]
    assert pieces_min(blocked) <= len(rings)


@settings(max_examples=examples(60), deadline=None)
@given(grids)
def test_every_blocked_cell_is_in_an_obstacle_and_no_free_one(blocked: Flags) -> None:
    check(blocked)


@pytest.mark.parametrize("density", [0.3, 0.6, 0.9])
def test_so_it_is_where_holes_and_many_corners_are_cut(density: float) -> None:
    check(np.random.default_rng(7).random((32, 32)) < density)


def test_an_outline_with_many_corners_is_cut() -> None:
    comb = np.ones((2, CORNERS_MAX), dtype=np.bool_)
    comb[1, ::2] = False
    assert len(outlines(comb)) > 1
    check(comb)


def test_a_straight_wall_has_four_corners_and_a_corner_that_two_cells_share_parts_them() -> None:
    assert [len(ring) for ring in outlines(np.ones((3, 50), dtype=np.bool_))] == [4]
    assert [len(ring) for ring in outlines(np.eye(2, dtype=np.bool_))] == [4, 4]


@settings(max_examples=examples(40), deadline=None)
@given(grids, st.integers(1, 4))
def test_coarser_cells_are_blocked_where_any_of_theirs_is_and_beyond_the_rim(blocked: Flags, by: int) -> None:
    coarse = coarsened(blocked, by)
    rows, columns = blocked.shape
    for row, column in np.ndindex(*coarse.shape):
        block = blocked[row * by : (row + 1) * by, column * by : (column + 1) * by]
        assert coarse[row, column] == (block.any() or (row + 1) * by > rows or (column + 1) * by > columns)
