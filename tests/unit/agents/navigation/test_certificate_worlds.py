"""The certificate against shapely: certified steps are safe, and refusals have a reason."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings

from agents.navigation.certificate import (
    certified_lengths_m,
    promised_clearance_m,
    scan_walls,
    short_step_m,
    short_step_walls,
)
from protocol.arrays import Floats
from tests.support.scenes.standpoints import (
    HEADINGS,
    HEADINGS_RAD,
    KEEP_M,
    RADIUS_M,
    Standpoint,
    standpoints,
)
from tests.support.strategies.examples import examples
from world.geometry.shapes import Circle, Polygon, Shape

ROUNDING_M = 1e-8
SAMPLE_M = 0.01  # spacing of samples on the outline of the free polygon
BEYOND_M = 1e-3  # further than certified

patiently = settings(max_examples=examples(30))


def certified_m(there: Standpoint) -> Floats:
    """How far the robot may go in each of `HEADINGS`."""
    walls = scan_walls(there.view, there.mission)
    return certified_lengths_m(there.position, HEADINGS_RAD, walls)


def least_kept_m(there: Standpoint) -> float:
    """The distance of the centre from every shape: r + epsilon, or less if it stands nearer already.

    A robot in contact may drive along the surface, at a right angle to the nearest point of an edge. A part
    hidden between two rays can be ahead by one ray spacing, and is passed at the cosine of that.
    """
    keep_m = there.radius_m + there.epsilon_m
    return min(keep_m, there.off_m) * math.cos(math.tau / there.directions) - ROUNDING_M


def assert_certified_steps_are_safe(there: Standpoint) -> None:
    moves = there.moves(certified_m(there))
    assert there.true_distance_m(moves).min() >= least_kept_m(there)


@settings(max_examples=examples(60))
@given(standpoints())
def test_no_certified_step_comes_nearer_than_epsilon_to_any_shape(there: Standpoint) -> None:
    assert_certified_steps_are_safe(there)


@patiently
@given(standpoints())
def test_no_short_step_comes_nearer_to_any_shape_than_half_of_the_tolerance_less(there: Standpoint) -> None:
    walls = short_step_walls(there.view, there.mission)
    lengths_m = np.minimum(
        certified_lengths_m(there.position, HEADINGS_RAD, walls), short_step_m(there.mission)
    )
    spent_m = there.mission.mu0_m / 2.0 * math.cos(math.tau / there.directions)
    assert there.true_distance_m(there.moves(lengths_m)).min() >= least_kept_m(there) - spent_m


@patiently
@given(standpoints())
def test_no_promise_exceeds_the_true_clearance(there: Standpoint) -> None:
    lengths_m = certified_m(there)
    true_m = there.true_distance_m(there.moves(lengths_m)) - RADIUS_M
    nobody = np.zeros(there.directions, dtype=np.bool_)
    promised_m = [
        promised_clearance_m(there.view, there.position + length_m * heading, nobody, there.mission)
        for length_m, heading in zip(lengths_m, HEADINGS, strict=True)
    ]
    assert (np.array(promised_m) <= true_m + ROUNDING_M).all()


@patiently
@given(standpoints())
def test_the_disc_of_a_certified_step_stays_in_the_free_polygon(there: Standpoint) -> None:
    lengths_m = certified_m(there)
    moves = there.moves(lengths_m)
    keep_m = KEEP_M + there.range_error_m
    edge_m = float(shapely.distance(there.free.exterior, shapely.Point(there.position)))
    assert shapely.covers(there.free, moves).all()
    assert shapely.distance(there.free.exterior, moves).min() >= min(keep_m, edge_m) - ROUNDING_M


@patiently
@given(standpoints())
def test_each_refused_step_could_touch_something_hidden_from_the_scan(there: Standpoint) -> None:
    lengths_m = certified_m(there)
    true_m = np.maximum(there.view.ranges_m - there.range_error_m, 0.0)
    share = there.mission.sure_share_in(there.directions)
    gap_m = share * np.minimum(true_m, np.roll(true_m, -1))
    ends_rad = there.view.bearings_rad[:, None] + (0.0, math.tau / there.directions)
    corners = gap_m[:, None, None] * np.stack([np.cos(ends_rad), np.sin(ends_rad)], axis=2)
    outline = shapely.LinearRing((there.position + corners).reshape(-1, 2))
    places = shapely.get_coordinates(shapely.segmentize(outline, SAMPLE_M))
    longer = there.moves(lengths_m + BEYOND_M)
    touched = shapely.distance(longer[:, None], shapely.points(places)[None, :]) <= KEEP_M + SAMPLE_M
    ahead = HEADINGS @ (places - there.position).T >= -SAMPLE_M
    assert (touched & ahead).any(axis=1).all()


def needle(tip_m: tuple[float, float], heading_rad: float, opening_rad: float = 0.5) -> Polygon:
    """A spike of 1 m that begins at its tip."""
    ends = [heading_rad + side * opening_rad / 2.0 for side in (-1.0, 1.0)]
    corners = [(tip_m[0] + math.cos(end), tip_m[1] + math.sin(end)) for end in ends]
    return Polygon(vertices_m=(tip_m, *corners))


def box(x_m: float, y_m: float, long_m: float, thick_m: float) -> Polygon:
    """A box from its lower left corner."""
    return Polygon(
        vertices_m=(
            (x_m, y_m),
            (x_m + long_m, y_m),
            (x_m + long_m, y_m + thick_m),
            (x_m, y_m + thick_m),
        )
    )


SURE_POST_M = 4.0 * math.tau / 360  # fills one spacing of 360 rays at 4 m

HARD: dict[str, list[Shape]] = {
    "a spike that points at the robot": [needle((0.4, 0.0), 0.0)],
    "a spike across the way": [needle((0.5, -0.1), 1.4)],
    "a spike that leans along the rays": [needle((0.4, 0.05), 0.3, 0.2)],
    "a spike partly behind a post": [
        Circle(centre_m=(0.6, 0.15), radius_m=0.15),
        needle((0.9, -0.02), 0.6),
    ],
    "posts at the limit of the sure range": [
        Circle(centre_m=(3.9, y_m), radius_m=SURE_POST_M / 2.0) for y_m in (-0.9, 0.0, 1.3)
    ],
    "posts half beyond the range limit": [Circle(centre_m=(4.03, 0.0), radius_m=SURE_POST_M / 2.0)],
    "posts that touch": [Circle(centre_m=(0.5, 0.15 * k), radius_m=0.075) for k in range(-3, 4)],
    "an inner corner": [box(0.3, -1.0, 0.2, 2.0), box(-1.0, 0.3, 1.4, 0.2)],
    "a slit between two walls": [box(0.3, -1.02, 0.2, 1.0), box(0.3, 0.02, 0.2, 1.0)],
    "a slit that admits the robot": [box(0.5, -1.23, 0.2, 1.0), box(0.5, 0.23, 0.2, 1.0)],
    "a wall far behind a post": [
        Circle(centre_m=(0.5, 0.3), radius_m=0.07),
        box(2.5, -2.0, 0.2, 4.0),
    ],
    "a wall beside the robot, seen along it": [box(-1.0, 0.2, 3.0, 0.1)],
    "a wall that the robot touches with its hull": [box(-1.0, 0.15 + 1e-6, 3.0, 0.1)],
}


@pytest.mark.parametrize("directions", [24, 90, 360])
@pytest.mark.parametrize("shapes", HARD.values(), ids=HARD.keys())
def test_certified_steps_are_safe_around_hard_shapes_between_two_rays(
    shapes: list[Shape], directions: int
) -> None:
    spacing_rad = math.tau / directions
    for turn in np.linspace(0.0, spacing_rad, 12, endpoint=False).tolist():
        there = Standpoint(tuple(turned(shape, turn) for shape in shapes), np.zeros(2), directions, 0.0, 0)
        assert_certified_steps_are_safe(there)


def turned(shape: Shape, by_rad: float) -> Shape:
    """The same shape, turned about the robot."""
    match shape:
        case Circle():
            return Circle(centre_m=rotated(shape.centre_m, by_rad), radius_m=shape.radius_m)
        case Polygon():
            return Polygon(vertices_m=tuple(rotated(corner, by_rad) for corner in shape.vertices_m))
        case _:
            raise AssertionError(shape)  # no other shapes are used


def rotated(point: tuple[float, float], by_rad: float) -> tuple[float, float]:
    (x, y), cosine, sine = point, math.cos(by_rad), math.sin(by_rad)
    return cosine * x - sine * y, sine * x + cosine * y
