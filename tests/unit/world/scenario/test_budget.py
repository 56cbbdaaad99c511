import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, example, given
from hypothesis import strategies as st

from protocol.arrays import Floats, scan_bearings_rad
from protocol.mission import BLIND_PER_RANGE_MAX
from tests.support.strategies.shape_strategies import as_shapely, patiently, shapes
from world.geometry.rays import cast
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape, ground_of
from world.scenario.budget import blind_per_range, budget, sure_range_m

DIRECTIONS = 360
FINER = 9  # reference rays per sensor ray; odd, so that one is half-way
RANGE_M_MAX = 6.0
SLIVER = Polygon(vertices_m=((0.8985, 2.4115), (1.5875, 4.0693), (1.4811, 4.1096)))
"""A corner of 3.6 degrees: to the first order of the ray spacing its unseen part is 28 % too small."""
NEEDLE = Polygon(vertices_m=((1.0, 0.002), (3.0, -0.3), (3.0, 0.3)))


def _scan(shape: Shape, directions: int, range_m_max: float, origin: Floats) -> Floats:
    """The ends of the rays, relative to their origin."""
    bearings_rad = scan_bearings_rad(directions)
    ranges_m = cast(ground_of([shape]), origin, bearings_rad, range_m_max=range_m_max, discs=np.empty((0, 3)))
    return np.column_stack((ranges_m * np.cos(bearings_rad), ranges_m * np.sin(bearings_rad)))


@patiently
@given(shapes)
@example(NEEDLE)
@example(Polygon(vertices_m=((1.0, 2.25), (0.0, 3.75), (1.0, 4.75), (1.5, 3.75))))  # leans along a ray
@example(Ellipse(centre_m=(2.0, 0.0), semi_axes_m=(1.0, 0.05), rotation_rad=0.002))
@example(Polygon(vertices_m=((-2.0285, -0.0556), (-2.0297, 0.0459), (-1.5631, 0.0222))))
@example(SLIVER)
def test_no_obstacle_extends_further_into_the_joined_hits_than_the_blind_distance(shape: Shape) -> None:
    range_m_max = min(RANGE_M_MAX, sure_range_m([shape], DIRECTIONS))
    seen = _scan(shape, DIRECTIONS, range_m_max, np.zeros(2))
    assume(np.hypot(*seen.T).min() > 0.0)
    truth = _scan(shape, DIRECTIONS * FINER, range_m_max, np.zeros(2))
    truth_m = np.hypot(*truth.T)
    hits = truth_m < range_m_max - 1e-9
    free = shapely.Polygon(seen)
    deep_m = shapely.distance(shapely.boundary(free), shapely.points(truth[hits]))
    deep_m *= shapely.contains_xy(free, truth[hits])
    assert (deep_m <= blind_per_range([shape], DIRECTIONS) * truth_m[hits] + 1e-9).all()


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


def test_the_blind_distance_is_the_ray_spacing_for_blunt_shapes_and_more_for_sharp_ones() -> None:
    spacing = math.tau / 1440
    post = Circle(centre_m=(0.0, 0.0), radius_m=0.1)
    wedge = Polygon(vertices_m=((0.0, 0.0), (math.sqrt(3.0), 1.0), (2.0, 0.0)))  # 30 degrees
    beyond = math.sin(spacing) / math.sin(math.pi / 6.0 - spacing)
    assert blind_per_range([], 1440) == pytest.approx(spacing)
    assert blind_per_range([post], 1440) == pytest.approx(spacing)
    assert blind_per_range([post, wedge], 1440) == pytest.approx(beyond)


def test_beside_a_corner_that_two_rays_may_hide_whole_nothing_is_certified() -> None:
    needle = Polygon(vertices_m=((0.0, 0.0), (2.0, 0.001), (2.0, 0.0)))
    assert blind_per_range([needle], 360) == BLIND_PER_RANGE_MAX


def test_at_the_sure_range_the_thinnest_shape_fills_one_ray_spacing() -> None:
    post = Circle(centre_m=(0.0, 0.0), radius_m=0.1)
    assert sure_range_m([post], 360) * math.tau / 360 == pytest.approx(0.2)
    assert sure_range_m([], 360) == math.inf


def test_the_budget_adds_its_three_shares() -> None:
    errors = budget(rays=90, closest_m=0.2, range_sigma_m=0.001, heading_error_rad=0.0001, range_m_max=4.0)
    assert errors.quantisation_m == pytest.approx(0.2 * (1.0 - math.cos(math.radians(4.0))))
    assert errors.range_noise_m == pytest.approx(0.003)
    assert errors.drive_m == pytest.approx(0.0012)
    assert errors.total_m == pytest.approx(errors.quantisation_m + 0.0042)
