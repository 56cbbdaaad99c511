"""The independent planner knows the widths that its scenes were made with."""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from clew.fields.field import Field, scene
from clew.fields.kinds import Kind
from tests.support.scenes.full_map import QUARTER_CHORDS, Answer, Disc, solvable
from tests.support.strategies.examples import examples

GAP_M = 1.0
DOOR: dict[str, Any] = {
    "start": [-2.0, 0.0, 0.0],
    "goal": [2.0, 0.0],
    "goal_tol": 0.1,
    "bounds": [-4.0, -3.0, 4.0, 3.0],
    "circles": [],
    "polygons": [[[-0.1, GAP_M / 2.0], [0.1, GAP_M / 2.0], [0.1, 3.0], [-0.1, 3.0]]],
    "walls": [[[-0.1, -3.0], [0.1, -3.0], [0.1, -GAP_M / 2.0], [-0.1, -GAP_M / 2.0]]],
}
POSTS = DOOR | {
    "polygons": [[[-0.1, 1.5], [0.1, 1.5], [0.1, 3.0], [-0.1, 3.0]]],
    "walls": [[[-0.1, -3.0], [0.1, -3.0], [0.1, -1.5], [-0.1, -1.5]]],
    "circles": [[0.0, 1.0, 0.5], [0.0, -1.0, 0.5]],
}


@pytest.mark.parametrize("scene", [DOOR, POSTS], ids=["door", "posts"])
def test_a_disc_passes_exactly_where_it_is_thinner_than_the_gap(scene: dict[str, Any]) -> None:
    assert solvable(scene, Disc(0.4999 * GAP_M)) is not Answer.UNSOLVABLE
    assert solvable(scene, Disc(0.499 * GAP_M)) is Answer.SOLVABLE
    assert solvable(scene, Disc(0.501 * GAP_M)) is Answer.UNSOLVABLE


def test_a_disc_as_wide_as_the_gap_is_between() -> None:
    assert solvable(DOOR, Disc(GAP_M / 2.0)) is Answer.BETWEEN


@pytest.mark.parametrize("turn_chords", [0.0, 0.25, 0.5])
def test_the_chords_of_arcs_never_decide_however_they_fall(turn_chords: float) -> None:
    turn_rad = turn_chords * math.pi / 2.0 / QUARTER_CHORDS
    x, y = math.sin(turn_rad), math.cos(turn_rad)
    posts = POSTS | {"circles": [[x, y, 0.5], [-x, -y, 0.5]]}
    assert solvable(posts, Disc(GAP_M / 2.0 + 1e-5)) is not Answer.SOLVABLE
    assert solvable(posts, Disc(GAP_M / 2.0 - 1e-5)) is not Answer.UNSOLVABLE


def test_the_clearance_counts_like_a_larger_disc_but_not_towards_the_bounds() -> None:
    assert solvable(DOOR, Disc(0.3, 0.19)) is Answer.SOLVABLE
    assert solvable(DOOR, Disc(0.3, 0.21)) is Answer.UNSOLVABLE
    beside = {"start": [-2.0, 2.69, 0.0], "goal": [-1.0, 2.69]}
    assert solvable(DOOR | beside, Disc(0.3, 0.19)) is Answer.SOLVABLE
    assert solvable(DOOR | beside, Disc(0.32, 0.0)) is Answer.UNSOLVABLE


def test_the_goal_is_reached_within_its_tolerance() -> None:
    in_the_wall = DOOR | {"goal": [0.0, 2.0]}  # whose side is 0.1 m away
    assert solvable(in_the_wall | {"goal_tol": 0.56}, Disc(0.45)) is Answer.SOLVABLE
    assert solvable(in_the_wall | {"goal_tol": 0.54}, Disc(0.45)) is Answer.UNSOLVABLE


def test_there_is_no_way_from_closed_ground() -> None:
    assert solvable(DOOR | {"start": [0.0, 2.0, 0.0]}, Disc(0.1)) is Answer.UNSOLVABLE


@given(st.integers(0, 4), st.floats(0.02, 0.6), st.floats(0.0, 0.1))
@settings(max_examples=examples(25))
def test_a_larger_disc_never_gets_where_a_smaller_one_does_not(
    seed: int, radius_m: float, more_m: float
) -> None:
    crowded = scene(Field(kind=Kind.MIXED, seed=seed, size_m=(3.0, 3.0), density=0.3, least_width_m=0.0))
    smaller, larger = solvable(crowded, Disc(radius_m)), solvable(crowded, Disc(radius_m + more_m))
    ranks = [Answer.UNSOLVABLE, Answer.BETWEEN, Answer.SOLVABLE]
    assert ranks.index(larger) <= ranks.index(smaller)


def test_what_is_between_is_within_the_error_of_the_chords() -> None:
    error_m = 0.5 * (1.0 / math.cos(math.pi / 4.0 / QUARTER_CHORDS) - 1.0)
    assert solvable(POSTS, Disc(GAP_M / 2.0 - 2.1 * error_m)) is Answer.SOLVABLE
    assert solvable(POSTS, Disc(GAP_M / 2.0 + 2.1 * error_m)) is Answer.UNSOLVABLE
