import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from protocol.arrays import Floats, scan_bearings_rad
from protocol.mission import SEEN_SHARE
from protocol.path import THERE_M
from tests.support.strategies.shape_strategies import as_shapely, patiently, shapes
from world.geometry.rays import cast
from world.geometry.shapes import Circle, Shape, ground_of
from world.scenario.budget import budget, sure_range_m

DIRECTIONS = 360


def _scan(shape: Shape, directions: int, range_m_max: float, origin: Floats) -> Floats:
    """The ends of the rays, relative to their origin."""
    bearings_rad = scan_bearings_rad(directions)
    ranges_m = cast(ground_of([shape]), origin, bearings_rad, range_m_max=range_m_max, discs=np.empty((0, 3)))
    return np.column_stack((ranges_m * np.cos(bearings_rad), ranges_m * np.sin(bearings_rad)))


@patiently
@given(shapes, st.floats(-math.pi, math.pi))
def test_within_the_sure_range_every_obstacle_is_hit(shape: Shape, bearing_rad: float) -> None:
    range_m_max = sure_range_m([shape], DIRECTIONS) * 0.999
    middle = as_shapely(shape).centroid
    outline = shapely.get_coordinates(as_shapely(shape))
    largest_m = np.hypot(outline[:, 0] - middle.x, outline[:, 1] - middle.y).max()
    away_m = max(range_m_max - largest_m, 0.0)  # as far away as possible with the whole shape in range
    origin = np.array((middle.x + away_m * math.cos(bearing_rad), middle.y + away_m * math.sin(bearing_rad)))
    assert np.hypot(*_scan(shape, DIRECTIONS, range_m_max, origin).T).min() < range_m_max - 1e-9


def test_at_the_sure_range_the_thinnest_shape_fills_one_ray_spacing() -> None:
    post = Circle(centre_m=(0.0, 0.0), radius_m=0.1)
    assert sure_range_m([post], 360) * math.tau / 360 == pytest.approx(0.2)
    assert sure_range_m([], 360) == math.inf


def test_the_budget_adds_its_four_shares() -> None:
    errors = budget(rays=90, closest_m=0.2, range_sigma_m=0.001, heading_error_rad=0.0001, range_m_max=4.0)
    assert errors.quantisation_m == pytest.approx(0.2 * (1.0 - math.cos(math.radians(4.0))))
    assert errors.range_noise_m == pytest.approx(0.003)
    assert errors.drive_m == pytest.approx(0.0016)
    assert errors.total_m == pytest.approx(errors.quantisation_m + 0.0046 + errors.rounding_m)
    assert errors.rounding_m == pytest.approx(4.0 * THERE_M)


def test_two_drives_err_by_no_more_than_a_check_of_bodies_leaves_to_them() -> None:
    """F6: of a body that the robot ahead hides, a follower knows only that the robot ahead has passed it."""
    errors = budget(rays=90, closest_m=0.2, range_sigma_m=0.0, heading_error_rad=0.001, range_m_max=4.0)
    least_mu0_m = errors.drive_m
    assert (1.0 - SEEN_SHARE) * least_mu0_m >= 2.0 * 4.0 * 0.001
