"""The clearance of the straight way ahead, from a robot's own scan."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.leg import (
    certain_clearance_m,
    certain_clearance_m_min,
    place_is_clear,
    seen_clearance_m,
)
from protocol.arrays import Floats
from tests.support.stages.one_step import look_around, under
from world.geometry.shapes import Circle, Polygon

MISSION = under("certified", robot_radius_m=0.1, range_error_m_max=0.005)
NEAR_M = MISSION.robot_radius_m + MISSION.clear_m
POST_M = 0.02  # radius of the post
AHEAD = np.array([0.9, 0.0])


def seen(bearing_rad: float, off_m: float, errors_m: Floats | float = 0.0) -> tuple[float, float]:
    """The seen and the certain clearance of the way ahead, with a post whose face is `off_m` away."""
    centre_m = (off_m + POST_M) * np.array([np.cos(bearing_rad), np.sin(bearing_rad)])
    post = Circle(centre_m=(float(centre_m[0]), float(centre_m[1])), radius_m=POST_M)
    view = look_around([post], MISSION)
    view = replace(view, ranges_m=np.where(view.hits, view.ranges_m + errors_m, view.ranges_m))
    return seen_clearance_m(view, AHEAD, MISSION), certain_clearance_m(view, AHEAD, MISSION)


@given(st.floats(2.0, 4.0), st.floats(0.0, 0.95))
def test_a_post_that_is_too_near_does_not_keep_a_robot_if_the_way_leads_away(
    bearing_rad: float, share: float
) -> None:
    assert seen(bearing_rad, NEAR_M - 0.02 + share * 0.02)[0] >= MISSION.clear_m


@given(st.floats(0.0, 2.0 * np.pi), st.floats(0.0, 1.0), st.integers(1, 1000))
def test_where_a_leg_begins_a_post_matters_also_if_the_leg_leads_away(
    bearing_rad: float, share: float, seed: int
) -> None:
    """Where the strand turns round a robot comes back there, and its drive errs once more."""
    least_m = MISSION.epsilon_m - MISSION.mu0_m
    off_m = MISSION.robot_radius_m + least_m + share * (certain_clearance_m_min(MISSION) - least_m)
    errors_m = np.random.default_rng(seed).uniform(-1.0, 1.0, MISSION.directions) * MISSION.range_error_m_max
    assert seen(bearing_rad, off_m, errors_m)[1] < certain_clearance_m_min(MISSION)


@given(st.floats(0.0, 2.0 * np.pi), st.sampled_from([(-0.001, False), (0.006, True)]))
def test_another_robot_may_come_to_a_place_that_is_off_a_post_by_what_its_drive_may_be_off(
    bearing_rad: float, case: tuple[float, bool]
) -> None:
    """A quarter of the tolerance is for that drive; the scan is sure to some millimetres."""
    spare_m, is_clear = case
    least_m = MISSION.robot_radius_m + MISSION.clear_m - 0.75 * MISSION.mu0_m
    off_m = least_m + MISSION.range_error_m_max + spare_m + POST_M
    x_m, y_m = off_m * np.cos(bearing_rad), off_m * np.sin(bearing_rad)
    post = Circle(centre_m=(float(x_m), float(y_m)), radius_m=POST_M)
    assert place_is_clear(look_around([post], MISSION), MISSION) == is_clear


@pytest.mark.parametrize("off_m", [NEAR_M - 0.02, NEAR_M + 0.002])
def test_a_post_as_near_on_the_way_ahead_does_matter(off_m: float) -> None:
    assert max(seen(0.0, off_m)) < 0.0


@pytest.mark.parametrize("tip_m", [0.75, 0.8, 0.85])
def test_a_leg_is_not_clear_where_two_rays_that_meet_nothing_may_pass_a_corner(tip_m: float) -> None:
    """A needle points at the sensor, between two rays that are a degree apart, from beyond the range."""
    rays = {"range_m_max": 1.5, "directions": 360, "sharpest_corner_rad": math.radians(1.8)}
    mission = under("certified", robot_radius_m=0.1, **rays)
    along = np.array([math.cos(math.radians(7.5)), math.sin(math.radians(7.5))])
    beside = 0.018 * np.array([-along[1], along[0]])
    ring = (tip_m * along, (tip_m + 1.1) * along - beside, (tip_m + 1.1) * along + beside)
    needle = Polygon(vertices_m=tuple((float(x), float(y)) for x, y in ring))
    view = look_around([needle], mission)
    assert not view.hits.any()
    assert certain_clearance_m(view, AHEAD, mission) <= tip_m * along[1] - mission.robot_radius_m
    closest = look_around([needle], mission, revolutions=20)
    assert closest.hits.any()


def test_what_may_be_beyond_a_legs_end_where_no_ray_meets_anything_does_not_count() -> None:
    """The robot that stands there keeps off it."""
    view = look_around([], MISSION)
    end = np.array([MISSION.range_m_max - 0.15, 0.0])
    assert certain_clearance_m(view, end, MISSION) >= certain_clearance_m_min(MISSION)
