import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.gaps import Gap, find_gaps, is_passable
from agents.navigation.obstacles import Obstacle, find_obstacles
from tests.support.strategies.scans import NOTHING_M, ranges, turned, view_of

PASSABLE_M = 0.5


def obstacles_of(ranges_m: list[float]) -> list[Obstacle]:
    return find_obstacles(view_of(ranges_m), passable_m=PASSABLE_M)


def posts(*directions: int) -> list[float]:
    ranges_m = [NOTHING_M] * 36
    for direction in directions:
        ranges_m[direction] = 1.0
    return ranges_m


@given(ranges())
def test_each_obstacle_has_one_gap_on_either_side_unless_it_is_the_only_one(ranges_m: list[float]) -> None:
    obstacles = obstacles_of(ranges_m)
    gaps = find_gaps(obstacles)
    everyone = list(range(len(obstacles))) if len(obstacles) > 1 else []
    assert [gap.right for gap in gaps] == everyone
    assert sorted(gap.left for gap in gaps) == everyone
    assert all(gap.left == (gap.right + 1) % len(obstacles) for gap in gaps)


@given(ranges())
def test_width_and_middle_are_those_of_the_line_between_the_tangent_points(ranges_m: list[float]) -> None:
    obstacles = obstacles_of(ranges_m)
    for gap in find_gaps(obstacles):
        right, left = obstacles[gap.right].tangent_2, obstacles[gap.left].tangent_1
        assert gap.width_m == pytest.approx(math.dist(right, left))
        assert gap.middle.tolist() == pytest.approx(((right + left) / 2.0).tolist())


@given(ranges())
def test_the_angle_of_a_gap_runs_anti_clockwise_from_its_right_to_its_left_side(
    ranges_m: list[float],
) -> None:
    obstacles = obstacles_of(ranges_m)
    for gap in find_gaps(obstacles):
        assert 0.0 <= gap.delta_rad < math.tau
        assert gap.axis_rad == obstacles[gap.right].bearing_2_rad
        turn = gap.axis_rad + gap.delta_rad - obstacles[gap.left].bearing_1_rad
        assert math.remainder(turn, math.tau) == pytest.approx(0.0, abs=1e-9)


@given(ranges())
def test_the_angles_of_obstacles_and_gaps_add_up_to_a_full_turn(ranges_m: list[float]) -> None:
    obstacles = obstacles_of(ranges_m)
    gaps = find_gaps(obstacles)
    covered = [(each.bearing_2_rad - each.bearing_1_rad) % math.tau for each in obstacles]
    if gaps:
        assert sum(covered) + sum(gap.delta_rad for gap in gaps) == pytest.approx(math.tau)


@given(ranges(), st.integers(0, 80))
def test_gaps_turn_with_the_surroundings(ranges_m: list[float], directions: int) -> None:
    before, after = find_gaps(obstacles_of(ranges_m)), find_gaps(obstacles_of(turned(ranges_m, directions)))
    turn_rad = math.tau * directions / len(ranges_m)
    assert _middles(after) == pytest.approx(_middles(before, turn_rad), abs=1e-9)
    sides = [sorted((gap.width_m, gap.delta_rad) for gap in gaps) for gaps in (before, after)]
    assert np.array(sides[1]).ravel().tolist() == pytest.approx(np.array(sides[0]).ravel().tolist())


def _middles(gaps: list[Gap], turned_rad: float = 0.0) -> list[float]:
    """Distances of the middles from places that turn with them: a pattern independent of their order."""
    cosine, sine = math.cos(turned_rad), math.sin(turned_rad)
    turned_middles = [(cosine * x - sine * y, sine * x + cosine * y) for x, y in (gap.middle for gap in gaps)]
    beacons = [(9.0, 0.0), (0.0, 9.0), (-5.0, -7.0)]
    return [sum(math.dist(beacon, middle) for middle in turned_middles) for beacon in beacons]


@pytest.mark.parametrize("ranges_m", [[NOTHING_M] * 8, posts(3), [0.2] * 36])
def test_without_two_obstacles_there_is_no_gap(ranges_m: list[float]) -> None:
    assert find_gaps(obstacles_of(ranges_m)) == []


def test_a_gap_ahead_opens_towards_the_robot_and_the_one_behind_does_not() -> None:
    behind, ahead = find_gaps(obstacles_of(posts(15, 21)))[::-1]
    assert (ahead.delta_rad, behind.delta_rad) == pytest.approx((math.tau / 6.0, math.tau * 5.0 / 6.0))
    assert ahead.width_m == pytest.approx(1.0)
    assert is_passable(ahead, passable_m=0.9)
    assert not is_passable(behind, passable_m=0.9)


def test_a_gap_is_passable_from_exactly_the_required_width() -> None:
    ahead = find_gaps(obstacles_of(posts(15, 21)))[0]
    assert is_passable(ahead, passable_m=ahead.width_m)
    assert not is_passable(ahead, passable_m=math.nextafter(ahead.width_m, math.inf))


def test_two_posts_on_opposite_sides_leave_no_gap_that_opens_towards_the_robot() -> None:
    gaps = find_gaps(obstacles_of(posts(0, 18)))
    assert [gap.delta_rad for gap in gaps] == pytest.approx([math.pi, math.pi])
    assert not any(is_passable(gap, passable_m=0.1) for gap in gaps)
