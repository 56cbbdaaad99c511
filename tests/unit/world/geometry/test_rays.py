import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from protocol.arrays import scan_bearings_rad
from tests.support.strategies.shape_strategies import (
    ORACLE_ERROR_M,
    as_shapely,
    grounds,
    patiently,
    points,
    shapes,
)
from world.geometry.rays import cast, noisy
from world.geometry.shapes import Circle, Polygon, Shape, ground_of

RANGE_M_MAX = 6.0
NO_DISCS = np.empty((0, 3))
Place = tuple[float, float]
shares = st.floats(0.01, 0.99)
bearings = st.lists(st.floats(-math.pi, math.pi), min_size=1, max_size=8)


def _scan(shapes: list[Shape], origin: Place, bearings_rad: list[float]) -> list[float]:
    ranges_m = cast(
        ground_of(shapes), np.array(origin), np.array(bearings_rad), range_m_max=RANGE_M_MAX, discs=NO_DISCS
    )
    listed: list[float] = ranges_m.tolist()
    return listed


def _ray(origin: Place, bearing_rad: float, range_m: float) -> shapely.LineString:
    x_m, y_m = origin
    return shapely.LineString(
        [origin, (x_m + range_m * math.cos(bearing_rad), y_m + range_m * math.sin(bearing_rad))]
    )


@patiently
@given(grounds, points, bearings)
def test_a_range_ends_at_the_first_intersection_that_shapely_finds(
    shapes: list[Shape], origin: Place, bearings_rad: list[float]
) -> None:
    solid = shapely.union_all([as_shapely(shape) for shape in shapes])
    assume(not shapely.dwithin(solid, shapely.Point(origin), ORACLE_ERROR_M))
    for bearing_rad, range_m in zip(bearings_rad, _scan(shapes, origin, bearings_rad), strict=True):
        # Rounding decides about a grazing ray, so the claim is about touching within the error.
        before = _ray(origin, bearing_rad, max(range_m - 1e-4, 0.0))
        assert not before.intersects(solid.buffer(-ORACLE_ERROR_M))
        if range_m < RANGE_M_MAX:
            assert shapely.Point(_ray(origin, bearing_rad, range_m).coords[-1]).dwithin(solid, ORACLE_ERROR_M)


@patiently
@given(grounds, shapes, shares, shares, bearings)
def test_all_ranges_are_zero_from_an_origin_inside_a_shape(
    others: list[Shape], around: Shape, up: float, across: float, bearings_rad: list[float]
) -> None:
    inside = as_shapely(around).buffer(-2.0 * ORACLE_ERROR_M)
    assume(not inside.is_empty)  # for the thinnest shapes the reference has no certain inside
    x_m_min, y_m_min, x_m_max, y_m_max = inside.bounds
    y_m = y_m_min + up * (y_m_max - y_m_min)
    chord = inside.intersection(shapely.LineString([(x_m_min - 1.0, y_m), (x_m_max + 1.0, y_m)]))
    assume(chord.length > 0.0)
    origin = chord.interpolate(across, normalized=True)
    assert _scan([*others, around], (origin.x, origin.y), bearings_rad) == [0.0] * len(bearings_rad)


def test_another_bodys_hull_hides_what_is_behind_it() -> None:
    wall: list[Shape] = [Polygon(vertices_m=((3.0, -1.0), (4.0, -1.0), (4.0, 1.0), (3.0, 1.0)))]
    discs = np.array([[2.0, 0.0, 0.5], [0.5, 0.0, 0.0]])  # the second is a point: no ray hits it
    ranges_m = cast(ground_of(wall), np.zeros(2), np.array([0.0, 0.3]), range_m_max=RANGE_M_MAX, discs=discs)
    assert ranges_m.tolist() == pytest.approx([1.5, 3.0 / math.cos(0.3)])


def test_no_ray_slips_through_the_corner_of_two_edges() -> None:
    vertices_m = tuple((math.cos(bearing), math.sin(bearing)) for bearing in np.linspace(0.1, 6.2, 40))
    shapes: list[Shape] = [Polygon(vertices_m=vertices_m)]
    origin = (-3.0, 0.2)
    at_corners_rad = [math.atan2(y - origin[1], x - origin[0]) for x, y in vertices_m]
    seen_rad = [bearing for bearing in at_corners_rad if abs(bearing) < 0.3]
    assert max(_scan(shapes, origin, seen_rad)) < RANGE_M_MAX


def test_a_scan_starts_at_minus_pi_and_goes_anticlockwise() -> None:
    assert scan_bearings_rad(8) == pytest.approx(np.arange(-4, 4) * math.pi / 4)


@patiently
@given(st.lists(st.floats(0.0, RANGE_M_MAX), max_size=30), st.integers(0, 2**32), st.floats(0.0, 0.1))
def test_noise_is_bounded_and_does_not_change_rays_without_a_hit(
    ranges: list[float], seed: int, sigma_m: float
) -> None:
    ranges_m = np.array([*ranges, RANGE_M_MAX])
    read_m = noisy(
        ranges_m,
        np.random.default_rng(seed),
        sigma_m=sigma_m,
        error_m_max=3 * sigma_m,
        range_m_max=RANGE_M_MAX,
    )
    assert read_m[-1] == RANGE_M_MAX
    assert ((read_m >= 0.0) & (read_m <= RANGE_M_MAX)).all()
    assert (np.abs(read_m - ranges_m) <= 3 * sigma_m + 1e-12).all()


def test_noise_has_the_requested_standard_deviation() -> None:
    ranges_m = np.full(10_000, 3.0)
    read_m = noisy(
        ranges_m, np.random.default_rng(1), sigma_m=0.01, error_m_max=0.03, range_m_max=RANGE_M_MAX
    )
    assert read_m.std() == pytest.approx(0.01, rel=0.05)
    assert np.abs(read_m - ranges_m).max() == pytest.approx(0.03)  # some of 10,000 were clipped


def test_a_circle_out_of_range_is_not_seen() -> None:
    far: list[Shape] = [Circle(centre_m=(7.5, 0.0), radius_m=1.0)]
    assert _scan(far, (0.0, 0.0), [0.0]) == [RANGE_M_MAX]
