import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import affinity

from protocol.arrays import Floats
from tests.support.strategies.shape_strategies import ORACLE_ERROR_M, as_shapely, patiently, points, polygons
from world.geometry.clearance import distances
from world.geometry.movers import Movers
from world.geometry.moving import Moving, MovingCircle, MovingPolygon
from world.geometry.shapes import Circle, Shape, ground_of

MOMENTS = 801  # samples of the reference, in the second that a move takes
ROUNDING_M = 1e-12  # both ways of computing a distance of metres are off by less
NOTHING = ground_of(())
radii_m = st.floats(0.05, 1.0)


@st.composite
def tracks(draw: st.DrawFn) -> tuple[tuple[float, float, float], ...]:
    """A few places, at hundredths of a second before, in and after the examined second."""
    at = draw(st.lists(st.integers(0, 300), min_size=1, max_size=5, unique=True))
    return tuple((hundredths / 100.0, *draw(points)) for hundredths in sorted(at))


circles = st.builds(MovingCircle, id=st.just("disc"), radius_m=radii_m, track=tracks())
rings = st.builds(
    MovingPolygon, id=st.just("ring"), vertices_m=polygons().map(lambda ring: ring.vertices_m), track=tracks()
)
moving = st.one_of(circles, rings)


def place(obstacle: Moving, t_s: float) -> tuple[float, float]:
    """Its place on its track, by an independent computation."""
    track = obstacle.track
    if t_s <= track[0][0]:
        return track[0][1:]
    for (begin_s, begin_x_m, begin_y_m), (end_s, end_x_m, end_y_m) in pairwise(track):
        if t_s <= end_s:
            share = (t_s - begin_s) / (end_s - begin_s)
            return begin_x_m + share * (end_x_m - begin_x_m), begin_y_m + share * (end_y_m - begin_y_m)
    return track[-1][1:]


def sampled_m(obstacle: Moving, start: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    """The least sampled distance, and how much less it may be between samples."""
    shares = np.linspace(0.0, 1.0, MOMENTS)
    bodies = np.array(start) + shares[:, None] * (np.array(end) - np.array(start))
    places = np.array([place(obstacle, 1.0 + share) for share in shares])
    shape = as_shapely(obstacle.outline)
    # Moving the body back by the obstacle's motion keeps their distance.
    apart_m = shapely.distance(shape, shapely.points(bodies - places))
    speed_mps = math.dist(start, end) + obstacle.speed_mps_max
    return float(apart_m.min()), speed_mps / (MOMENTS - 1) / 2.0 + ORACLE_ERROR_M


def approaches_m(
    obstacles: list[Moving], start: tuple[float, float], end: tuple[float, float], near_m: float = math.inf
) -> Floats:
    starts_m, ends_m = np.array([start]), np.array([end])
    told_m = Movers.of(obstacles).approaches_m(starts_m, ends_m, from_s=1.0, to_s=2.0, near_m=near_m)
    return told_m.reshape(-1)


@patiently
@given(moving, points, points)
def test_an_approach_is_the_least_distance_at_any_moment_of_two_moves(
    obstacle: Moving, start: tuple[float, float], end: tuple[float, float]
) -> None:
    least_m, less_m = sampled_m(obstacle, start, end)
    (approach_m,) = approaches_m([obstacle], start, end)
    assert least_m - less_m <= approach_m <= least_m + ORACLE_ERROR_M


@patiently
@given(st.lists(moving, min_size=1, max_size=4), points, points, st.floats(0.0, 2.0))
def test_only_distant_obstacles_may_be_underestimated_and_never_below_near_m(
    obstacles: list[Moving], start: tuple[float, float], end: tuple[float, float], near_m: float
) -> None:
    exact_m, told_m = approaches_m(obstacles, start, end), approaches_m(obstacles, start, end, near_m)
    assert (told_m <= exact_m + ROUNDING_M).all()
    assert (told_m[exact_m > near_m] > near_m - ROUNDING_M).all()
    assert told_m[exact_m <= near_m] == pytest.approx(exact_m[exact_m <= near_m])


@patiently
@given(st.lists(moving, max_size=4), points, st.floats(0.0, 4.0))
def test_the_ground_at_a_time_has_every_obstacle_at_its_place(
    obstacles: list[Moving], point: tuple[float, float], t_s: float
) -> None:
    standing: list[Shape] = [Circle(centre_m=(0.0, 0.0), radius_m=0.5)]
    ground = Movers.of(obstacles).among(ground_of(standing), t_s)
    expected_m = [as_shapely(standing[0]).distance(shapely.Point(point))] + [
        affinity.translate(as_shapely(each.outline), *place(each, t_s)).distance(shapely.Point(point))
        for each in obstacles
    ]
    assert distances(ground, np.array(point)) == pytest.approx(expected_m, abs=2 * ORACLE_ERROR_M)


def test_an_obstacle_that_passes_during_a_move_is_found() -> None:
    walker = MovingCircle(id="a", radius_m=0.1, track=((1.0, 0.5, -1.0), (1.5, 0.5, 0.0), (2.0, 0.5, -1.0)))
    assert approaches_m([walker], (0.0, 0.0), (1.0, 0.0)) == pytest.approx(0.0)
    assert approaches_m([walker], (0.0, 0.5), (1.0, 0.5)) == pytest.approx(0.4)


def test_parallel_motions_keep_their_distance() -> None:
    cart = MovingPolygon(
        id="a",
        vertices_m=((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)),
        track=((1.0, 0.0, 0.0), (2.0, 3.0, 0.0)),
    )
    assert approaches_m([cart], (0.5, 0.0), (3.5, 0.0)) == pytest.approx(0.4)


def test_without_moving_obstacles_the_ground_is_unchanged() -> None:
    assert Movers.of(()).among(NOTHING, 1.0) is NOTHING
