"""What a scan is sure of: between two rays nothing is nearer, whatever shapes there are."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from agents.navigation.sure import LEAST_M, closer, sure
from protocol.arrays import Floats
from protocol.frames import Pose
from protocol.mission import RAYS_MAX, Mission
from tests.support.scenes.arches import pointed_arch
from tests.support.stages.one_step import look_around, under
from tests.support.strategies.examples import examples
from tests.support.strategies.shape_strategies import patiently, shapes
from world.geometry.rings import is_simple
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape
from world.scenario.budget import sure_range_m
from world.scenario.corners import sharpest_corner_rad

FINER = 16  # reference rays per ray; even, so that one is half-way
RANGE_M_MAX = 6.0
RAYS = [24, 90, 360]
NEEDLE = Polygon(vertices_m=((1.0, 0.002), (3.0, -0.3), (3.0, 0.3)))
LEANS = Polygon(vertices_m=((1.0, 2.25), (0.0, 3.75), (1.0, 4.75), (1.5, 3.75)))  # along a ray
SLIVER = Polygon(vertices_m=((0.8985, 2.4115), (1.5875, 4.0693), (1.4811, 4.1096)))
"""A corner of 3.6 degrees."""


def mission(world: list[Shape], rays: int, **other: object) -> Mission:
    """What robots are told of this world."""
    range_m_max = min(RANGE_M_MAX, sure_range_m(world, rays))
    return under(
        "certified",
        directions=rays,
        range_m_max=range_m_max,
        sharpest_corner_rad=sharpest_corner_rad(world),
        **other,
    )


def nearest_m(world: list[Shape], told: Mission) -> Floats:
    """The true range of whatever is nearest in each gap between two rays, by finer rays."""
    truth = look_around(world, told, revolutions=FINER)
    return np.asarray(truth.ranges_m.reshape(-1, FINER).min(axis=1))


def assert_is_sure(world: list[Shape], rays: int) -> None:
    told = mission(world, rays)
    seen = look_around(world, told)
    nearest = nearest_m(world, told)
    assume(nearest.min() > LEAST_M)  # no sensor stands on an obstacle; from its corner, no ray hits it
    assert (nearest >= sure(seen, told).ranges_m - LEAST_M).all()


@patiently
@given(st.lists(shapes, min_size=1, max_size=4), st.sampled_from(RAYS))
@example([NEEDLE], 360)
@example([LEANS], 360)
@example([SLIVER], 360)
@example([Ellipse(centre_m=(2.0, 0.0), semi_axes_m=(1.0, 0.05), rotation_rad=0.002)], 360)
@example([Polygon(vertices_m=((-2.0285, -0.0556), (-2.0297, 0.0459), (-1.5631, 0.0222)))], 360)
def test_nothing_is_nearer_between_two_rays_than_the_scan_is_sure(world: list[Shape], rays: int) -> None:
    assert_is_sure(world, rays)


@st.composite
def sharp_things(draw: st.DrawFn) -> Polygon:
    """A thing with a sharp or a rounded tip: a wedge, a barb on a wall, or a slim ellipse of few corners."""
    half_rad, long_m = draw(st.floats(0.03, 0.8)), draw(st.floats(0.02, 1.5))
    wide_m, lean_m = long_m * math.tan(half_rad), long_m * draw(st.floats(-0.5, 0.5))
    match draw(st.integers(0, 3)):
        case 0:
            return Polygon(vertices_m=((0.0, 0.0), (long_m, lean_m - wide_m), (long_m, lean_m + wide_m)))
        case 1:
            barb = ((0.0, 0.0), (long_m, lean_m - wide_m), (long_m, lean_m + wide_m))
            wall = ((long_m, 3.0), (long_m + 1.0, 3.0), (long_m + 1.0, -3.0), (long_m, -3.0))
            return Polygon(vertices_m=(barb[0], barb[2], *wall, barb[1]))
        case 2:
            blunt_m = wide_m * draw(st.floats(0.05, 0.9))
            tip = ((0.0, blunt_m), (0.0, -blunt_m))
            return Polygon(vertices_m=(*tip, (long_m, lean_m - wide_m), (long_m, lean_m + wide_m)))
        case _:
            corners = math.tau * np.arange(draw(st.integers(5, 30))) / 30.0 * 30.0
            bearings = corners / len(corners) + math.pi
            ring = np.stack([long_m * (1.0 + np.cos(bearings)), 0.5 * wide_m * np.sin(bearings)], axis=1)
            return Polygon(vertices_m=tuple((float(x), float(y)) for x, y in ring))


@settings(max_examples=examples(150), deadline=None)
@given(
    sharp_things(), st.sampled_from(RAYS), st.floats(0.3, 1.0), st.floats(-3.14, 3.14), st.floats(-1.5, 1.5)
)
def test_nor_where_a_tip_points_at_the_sensor_from_as_far_as_it_is_sure_to_be_seen(
    thing: Polygon, rays: int, share: float, bearing_rad: float, turn_rad: float
) -> None:
    ring = np.array(thing.vertices_m)
    assume(is_simple(ring))
    range_m = share * min(RANGE_M_MAX, sure_range_m([thing], rays))
    heading_rad = bearing_rad + turn_rad
    cosine, sine = math.cos(heading_rad), math.sin(heading_rad)
    there = ring @ np.array([[cosine, sine], [-sine, cosine]])
    there += range_m * np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    assume(is_simple(there))
    assert_is_sure([Polygon(vertices_m=tuple((float(x), float(y)) for x, y in there))], rays)


@pytest.mark.parametrize("rays", RAYS)
@pytest.mark.parametrize("share", [0.8, 0.9, 0.98])
def test_nor_where_many_blunt_corners_make_a_sharp_tip(rays: int, share: float) -> None:
    """Between two rays stands all of a pointed arch, which is as wide as they are apart at its feet."""
    spacing_rad, width_m = math.tau / rays, 0.3 * RANGE_M_MAX / rays
    feet_m = share * width_m / spacing_rad
    tip_m = feet_m - width_m * math.sqrt(0.75)
    world: list[Shape] = [pointed_arch(width_m=width_m, tip_m=tip_m, bearing_rad=spacing_rad / 2.0)]
    told = mission(world, rays)
    assert (nearest_m(world, told) >= sure(look_around(world, told), told).ranges_m).all()


@pytest.mark.parametrize("degrees", [60.0, 30.0, 10.0, 4.0])
def test_a_tip_between_two_rays_reaches_as_near_as_is_allowed_for(degrees: float) -> None:
    half_rad, spacing_rad = math.radians(degrees) / 2.0, math.tau / 360
    ray_rad = spacing_rad / 2.0  # the tip is half-way between two rays, and points at the sensor
    hit_m, share = 2.0, math.sin(half_rad - ray_rad) / math.sin(half_rad)
    tip = share * hit_m * np.array([math.cos(ray_rad), math.sin(ray_rad)])
    sides = [
        tip + 1.5 * np.array([math.cos(ray_rad + s), math.sin(ray_rad + s)]) for s in (half_rad, -half_rad)
    ]
    wedge: list[Shape] = [Polygon(vertices_m=tuple((float(x), float(y)) for x, y in (tip, *sides)))]
    told = mission(wedge, 360)
    seen = look_around(wedge, told)
    gap = 180  # between bearing 0 and the next one
    assert seen.ranges_m[gap] == pytest.approx(hit_m), "both rays pass the tip and hit its sides"
    assert sure(seen, told).ranges_m[gap] == pytest.approx(nearest_m(wedge, told)[gap], rel=1e-9)


def at(place: tuple[float, float]) -> Pose:
    return Pose(x_m=place[0], y_m=place[1], heading_rad=0.0)


places = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))


@settings(max_examples=examples(100), deadline=None)
@given(
    st.lists(shapes, min_size=1, max_size=4), st.lists(places, min_size=1, max_size=3), st.sampled_from(RAYS)
)
def test_nor_do_rays_from_other_places_make_it_too_sure(
    world: list[Shape], others: list[tuple[float, float]], rays: int
) -> None:
    told = mission(world, rays)
    seen = look_around(world, told)
    earlier = tuple(look_around(world, told, at(place), revolutions=4) for place in others)
    nearest = nearest_m(world, told)
    assume(nearest.min() > LEAST_M)
    assume(all(each.ranges_m.min() > 0.0 for each in earlier))
    narrowed = sure(replace(seen, earlier=earlier), told)
    assert (nearest >= narrowed.ranges_m - LEAST_M).all()
    assert (narrowed.ranges_m >= sure(seen, told).ranges_m).all()


@settings(max_examples=examples(100), deadline=None)
@given(st.floats(0.03, 0.4), st.floats(-1.2, 1.2), places, st.sampled_from(RAYS))
def test_nor_where_a_tip_sticks_out_of_a_wall_between_two_rays(
    half_rad: float, lean_rad: float, place: tuple[float, float], rays: int
) -> None:
    """The tip reaches as near as the bound allows, and rays from the other place pass it on both sides."""
    spacing_rad = math.tau / rays
    towards = np.array([math.cos(spacing_rad / 2.0), math.sin(spacing_rad / 2.0)])
    long_m = 0.9 * math.sin(spacing_rad / 2.0) / math.tan(half_rad)
    tip, turn = (1.0 - long_m) * towards, spacing_rad / 2.0 + lean_rad * half_rad
    sides = [tip + 2.0 * np.array([math.cos(turn + s), math.sin(turn + s)]) for s in (half_rad, -half_rad)]
    wall = Polygon(vertices_m=((1.0, -3.0), (1.6, -3.0), (1.6, 3.0), (1.0, 3.0)))
    world: list[Shape] = [wall, Polygon(vertices_m=tuple((float(x), float(y)) for x, y in (tip, *sides)))]
    told = mission(world, rays)
    assume(long_m < 1.0 and told.range_m_max > 1.7)
    seen, other = look_around(world, told), look_around(world, told, at(place), revolutions=4)
    assume(other.ranges_m.min() > 0.0)
    narrowed = sure(replace(seen, earlier=(other,)), told)
    assert (nearest_m(world, told) >= narrowed.ranges_m - LEAST_M).all()


def test_rays_from_beside_cut_off_what_may_point_at_the_sensor() -> None:
    wall: list[Shape] = [Polygon(vertices_m=((1.0, -3.0), (1.5, -3.0), (1.5, 3.0), (1.0, 3.0)))]
    told = under("certified", directions=360, sharpest_corner_rad=math.radians(3.0))
    seen, beside = look_around(wall, told), look_around(wall, told, at((0.7, -1.0)), revolutions=4)
    alone_m = sure(seen, told).ranges_m[180]
    narrowed_m = sure(replace(seen, earlier=(beside,)), told).ranges_m[180]
    assert alone_m < 0.7, "a tip of 3 degrees may point at the sensor"
    assert narrowed_m > 0.97, "but not through the rays along the wall"


def test_beside_a_corner_that_two_rays_may_hide_whole_nothing_is_sure() -> None:
    needle: list[Shape] = [Polygon(vertices_m=((0.5, 0.0), (2.5, 0.001), (2.5, 0.0)))]
    assert mission(needle, 360).sure_share_in(360) == 0.0
    told = mission(needle, 360)
    known = sure(look_around(needle, told), told, leave_out=np.arange(360) < 3)
    assert np.isinf(known.ranges_m).tolist() == [True, True, *[False] * 358], "nothing, but no number either"


def test_a_range_error_counts_along_the_ray_and_a_ray_left_out_says_nothing() -> None:
    told = mission([], 8, range_error_m_max=0.1)
    seen = look_around([], told)
    known = sure(seen, told, leave_out=np.array([True, True, *[False] * 6]))
    expected_m = told.sure_share_in(8) * (RANGE_M_MAX - 0.1)
    assert np.isinf(known.ranges_m[0])
    assert known.ranges_m[1:] == pytest.approx(expected_m)


def test_closer_looks_have_four_times_the_rays_until_a_message_holds_no_more() -> None:
    told = mission([], 360)
    looks = [360]
    while (revolutions := closer(told, looks[-1])) is not None:
        looks.append(revolutions * 360)
    assert looks == [360, 1440, 5760, RAYS_MAX]


@pytest.mark.parametrize(
    ("shape", "angle_rad"),
    [
        (Circle(centre_m=(0.0, 0.0), radius_m=1.0), math.pi / 2),
        (Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(2.0, 1.0)), 2.0 * math.atan(0.5)),
    ],
)
def test_round_shapes_count_by_the_sharpest_wedge_over_them(shape: Shape, angle_rad: float) -> None:
    assert sharpest_corner_rad([shape]) == pytest.approx(angle_rad)
