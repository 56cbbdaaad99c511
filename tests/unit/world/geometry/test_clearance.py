import math
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st

from tests.support.strategies.shape_strategies import (
    ORACLE_ERROR_M,
    as_shapely,
    coordinates_m,
    grounds,
    patiently,
    points,
)
from world.geometry.clearance import clearance, clearance_at, distances, keep_off, separations
from world.geometry.ellipses import point_distances
from world.geometry.shapes import Ellipse, Polygon, Shape, ground_of

Place = tuple[float, float]
moves = st.lists(st.tuples(points, points), min_size=1, max_size=6)


@patiently
@given(grounds, moves)
def test_clearance_of_a_move_equals_shapelys_distance(
    shapes: list[Shape], driven: list[tuple[Place, Place]]
) -> None:
    starts, ends = (np.array(side) for side in zip(*driven, strict=True))
    expected = [
        min((shapely.LineString(move).distance(as_shapely(shape)) for shape in shapes), default=math.inf)
        for move in driven
    ]
    assert clearance(ground_of(shapes), starts, ends) == pytest.approx(expected, abs=ORACLE_ERROR_M)


@patiently
@given(grounds, moves, st.floats(0.0, 2.0))
def test_moves_from_outside_keep_off_by_less_than_their_clearance(
    shapes: list[Shape], driven: list[tuple[Place, Place]], apart_m: float
) -> None:
    ground = ground_of(shapes)
    starts, ends = (np.array(side) for side in zip(*driven, strict=True))
    outside = clearance(ground, starts, starts) > 0.0
    starts, ends = starts[outside], ends[outside]
    least_m = clearance(ground, starts, ends).min(initial=math.inf)
    if abs(least_m - apart_m) > ORACLE_ERROR_M:
        assert keep_off(ground, starts, ends, apart_m) is bool(least_m > apart_m)


@patiently
@given(grounds, points)
def test_distances_of_a_point_are_in_the_scenarios_order(shapes: list[Shape], point: Place) -> None:
    expected = [shapely.Point(point).distance(as_shapely(shape)) for shape in shapes]
    assert distances(ground_of(shapes), np.array(point)) == pytest.approx(expected, abs=ORACLE_ERROR_M)


@patiently
@given(grounds, points)
def test_a_body_at_rest_has_the_clearance_of_its_place(shapes: list[Shape], point: Place) -> None:
    ground, place = ground_of(shapes), np.array([point])
    expected = distances(ground, place[0]).min(initial=math.inf)
    assert clearance(ground, place, place)[0] == pytest.approx(expected, abs=1e-12)


@patiently
@given(grounds, st.lists(points, min_size=1, max_size=6))
def test_the_clearance_of_points_is_that_of_bodies_at_rest(shapes: list[Shape], places: list[Place]) -> None:
    ground, here = ground_of(shapes), np.array(places)
    assert clearance_at(ground, here) == pytest.approx(clearance(ground, here, here), abs=1e-12)


def test_a_move_through_a_polygon_has_no_clearance() -> None:
    square = Polygon(vertices_m=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))
    starts, ends = np.array([[-1.0, 0.5], [0.4, 0.5]]), np.array([[2.0, 0.5], [0.6, 0.5]])
    assert clearance(ground_of([square]), starts, ends).tolist() == [0.0, 0.0]


def test_a_long_wall_with_a_distant_middle_is_not_overlooked() -> None:
    wall = Polygon(vertices_m=((0.0, 0.0), (0.0, -0.1), (10.0, -0.1), (10.0, 0.0)))
    place = np.array([[9.0, 0.5]])
    assert clearance(ground_of([wall]), place, place).tolist() == [0.5]


def test_a_long_ellipse_does_not_hide_a_nearer_round_one() -> None:
    long = Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(2.5, 0.1))
    round_one = Ellipse(centre_m=(0.0, 5.0), semi_axes_m=(0.5, 0.6))
    place = np.array([[0.0, 3.0]])
    assert clearance(ground_of([long, round_one]), place, place) == pytest.approx([1.4])


@patiently
@given(
    st.floats(1e-3, 1.0).flatmap(lambda b: st.tuples(st.just(b), st.floats(-math.pi, math.pi))),
    st.floats(1e-9, 10.0),
)
@example((0.00135, 0.0157), 0.00133)  # where Newton's iteration needs most steps
def test_point_to_ellipse_is_exact_for_thin_ellipses(narrow: tuple[float, float], apart_m: float) -> None:
    a, (b, parameter_rad) = 1.0, narrow
    cosine, sine = math.cos(parameter_rad), math.sin(parameter_rad)
    outward = np.array([b * cosine, a * sine]) / math.hypot(b * cosine, a * sine)
    point = np.array([a * cosine, b * sine]) + apart_m * outward
    row = np.array([[0.0, 0.0, a, b, 0.0]])
    assert point_distances(row, point[None])[0] == pytest.approx(apart_m, abs=1e-12)


@patiently
@given(st.lists(st.tuples(points, points), min_size=2, max_size=5))
def test_separation_is_the_least_distance_at_any_common_instant(driven: list[tuple[Place, Place]]) -> None:
    starts, ends = (np.array(side) for side in zip(*driven, strict=True))
    measured = separations(starts, ends)
    shares = np.linspace(0.0, 1.0, 2001)[:, None]
    for i, j in combinations(range(len(driven)), 2):
        apart = (starts[i] - starts[j]) * (1.0 - shares) + (ends[i] - ends[j]) * shares
        sampled_m = np.hypot(*apart.T).min()
        step_m = np.hypot(*(ends[i] - ends[j] - starts[i] + starts[j])) / 2000
        assert sampled_m - step_m - 1e-12 <= measured[i, j] <= sampled_m + 1e-12
        assert measured[i, j] == measured[j, i]


@patiently
@given(coordinates_m)
def test_the_separation_of_a_body_from_itself_is_infinite(x_m: float) -> None:
    place = np.array([[x_m, 0.0]])
    assert separations(place, place).tolist() == [[math.inf]]
