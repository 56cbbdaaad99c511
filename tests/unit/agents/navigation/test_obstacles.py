import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.obstacles import Obstacle, find_obstacles, passable_width_m
from agents.navigation.scan import View
from tests.support.strategies.scans import NOTHING_M, ranges, turned, view_of

PASSABLE_M = 0.5
widths_m = st.floats(0.05, 2.0)


def ends(obstacle: Obstacle, directions: int) -> tuple[int, int]:
    """The indices of the directions in which its tangent points lie."""
    turns = [(bearing + math.pi) / math.tau for bearing in (obstacle.bearing_1_rad, obstacle.bearing_2_rad)]
    first, last = (round(turn * directions) for turn in turns)
    return first, last


def members(obstacle: Obstacle, directions: int) -> list[int]:
    """The directions from its first to its last, anti-clockwise."""
    first, last = ends(obstacle, directions)
    return [(first + step) % directions for step in range((last - first) % directions + 1)]


def apart_m(view: View, one: int, other: int) -> float:
    return float(np.hypot(*(view.points[one] - view.points[other])))


@given(ranges(), widths_m)
def test_every_hit_is_in_exactly_one_obstacle_and_no_other_direction_is(
    ranges_m: list[float], passable_m: float
) -> None:
    view = view_of(ranges_m)
    found = [
        member
        for obstacle in find_obstacles(view, passable_m=passable_m)
        for member in members(obstacle, len(ranges_m))
    ]
    assert sorted(found) == np.flatnonzero(view.hits).tolist()


@given(ranges(), widths_m)
def test_the_robot_cannot_pass_between_neighbouring_hits_of_one_obstacle(
    ranges_m: list[float], passable_m: float
) -> None:
    view = view_of(ranges_m)
    for obstacle in find_obstacles(view, passable_m=passable_m):
        for one, other in pairwise(members(obstacle, len(ranges_m))):
            assert apart_m(view, one, other) < passable_m


@given(ranges(), widths_m)
def test_two_obstacles_in_neighbouring_directions_are_far_enough_apart_to_pass(
    ranges_m: list[float], passable_m: float
) -> None:
    view, size = view_of(ranges_m), len(ranges_m)
    found = [ends(obstacle, size) for obstacle in find_obstacles(view, passable_m=passable_m)]
    for (_, last), (first, _) in zip(found, found[1:] + found[:1], strict=True):
        if (last + 1) % size == first and len(found) > 1:
            assert apart_m(view, last, first) >= passable_m


@given(ranges(), widths_m)
def test_obstacles_are_listed_anti_clockwise_from_behind(ranges_m: list[float], passable_m: float) -> None:
    found = find_obstacles(view_of(ranges_m), passable_m=passable_m)
    firsts = [obstacle.bearing_1_rad for obstacle in found]
    assert firsts == sorted(firsts)


@given(ranges(), widths_m, st.integers(0, 80))
def test_obstacles_turn_with_the_surroundings(
    ranges_m: list[float], passable_m: float, directions: int
) -> None:
    size = len(ranges_m)
    before = find_obstacles(view_of(ranges_m), passable_m=passable_m)
    after = find_obstacles(view_of(turned(ranges_m, directions)), passable_m=passable_m)
    expected = {frozenset((member + directions) % size for member in members(each, size)) for each in before}
    # A ring without an opening has no ends, at any angle.
    assert {frozenset(members(each, size)) for each in after} == expected
    assert sorted(each.chord_m for each in after) == pytest.approx(
        sorted(each.chord_m for each in before)
    ) or (len(before) == 1 and len(members(before[0], size)) == size)


@given(ranges(), widths_m)
def test_a_chord_is_the_distance_between_the_tangent_points(ranges_m: list[float], passable_m: float) -> None:
    view, size = view_of(ranges_m), len(ranges_m)
    for obstacle in find_obstacles(view, passable_m=passable_m):
        first, last = ends(obstacle, size)
        assert obstacle.tangent_1.tolist() == view.points[first].tolist()
        assert obstacle.tangent_2.tolist() == view.points[last].tolist()
        assert obstacle.chord_m == apart_m(view, first, last)


def test_a_scan_without_hits_has_no_obstacle() -> None:
    assert find_obstacles(view_of([NOTHING_M] * 8), passable_m=PASSABLE_M) == []


@pytest.mark.parametrize("direction", range(8))
def test_a_single_hit_is_an_obstacle_without_a_chord(direction: int) -> None:
    ranges_m = [NOTHING_M] * 8
    ranges_m[direction] = 1.0
    (obstacle,) = find_obstacles(view_of(ranges_m), passable_m=PASSABLE_M)
    assert ends(obstacle, 8) == (direction, direction)
    assert obstacle.chord_m == 0.0


def test_hits_all_around_without_an_opening_are_one_obstacle() -> None:
    (obstacle,) = find_obstacles(view_of([0.3] * 36), passable_m=PASSABLE_M)
    assert ends(obstacle, 36) == (0, 35)


def test_a_ring_with_one_jump_in_range_ends_at_that_jump() -> None:
    ring = [0.5] * 36
    ring[18:20] = [3.0, 3.1]
    found = find_obstacles(view_of(ring), passable_m=0.55)
    assert [ends(obstacle, 36) for obstacle in found] == [(18, 19), (20, 17)]


def test_a_run_across_the_seam_of_the_scan_is_one_obstacle() -> None:
    ranges_m = [NOTHING_M] * 36
    for direction in (34, 35, 0, 1, 2):
        ranges_m[direction] = 1.0
    for direction in (10, 11):
        ranges_m[direction] = 1.0
    found = find_obstacles(view_of(ranges_m), passable_m=PASSABLE_M)
    assert [ends(obstacle, 36) for obstacle in found] == [(10, 11), (34, 2)]


def test_the_passable_width_is_hull_and_clearance_on_both_sides() -> None:
    assert passable_width_m(0.1 + 0.05) == pytest.approx(0.3)
