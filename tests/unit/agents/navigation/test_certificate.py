"""The certificate holds: no step comes nearer to any shape than it promised."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.navigation.certificate import (
    Walls,
    bounds_walls,
    certified_lengths_m,
    ground_walls,
    promised_clearance_m,
    scan_walls,
    short_step_walls,
)
from agents.navigation.sure import sure
from protocol.arrays import unit_vectors
from protocol.mission import Bounds
from tests.support.stages.one_step import look_around, under, wall
from tests.support.strategies.examples import examples
from world.geometry.clearance import clearance
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape, ground_of

ROBOT = under(
    "certified",
    robot_radius_m=0.1,
    directions=720,
    sharpest_corner_rad=math.pi / 3,
)
KEEP_M = ROBOT.robot_radius_m + ROBOT.epsilon_m
HEADINGS_RAD = np.linspace(-np.pi, np.pi, 72, endpoint=False)
NOWHERE = np.zeros(2)


@st.composite
def scenes(draw: st.DrawFn) -> list[Shape]:
    """Posts, ellipses and regular polygons around a robot that does not touch them.

    All are wide enough to be seen at this range, and no corner is sharper than 60 degrees.
    """
    shapes: list[Shape] = []
    for _ in range(draw(st.integers(1, 8))):
        bearing_rad, radius_m = draw(st.floats(-3.1, 3.1)), draw(st.floats(0.05, 0.6))
        distance_m = draw(st.floats(KEEP_M + radius_m + 0.03, 3.5))
        centre_m = (distance_m * math.cos(bearing_rad), distance_m * math.sin(bearing_rad))
        turned_rad, corners = draw(st.floats(-3.1, 3.1)), draw(st.sampled_from([0, 1, 3, 4, 7]))
        shapes.append(_shape(centre_m, radius_m, turned_rad, corners))
    return shapes


def _shape(centre_m: tuple[float, float], radius_m: float, turned_rad: float, corners: int) -> Shape:
    """A circle, an ellipse (1) or a regular polygon inside the circle."""
    match corners:
        case 0:
            return Circle(centre_m=centre_m, radius_m=radius_m)
        case 1:
            axes = (radius_m, max(0.05, radius_m / 3.0))
            return Ellipse(centre_m=centre_m, semi_axes_m=axes, rotation_rad=turned_rad)
        case _:
            bearings = [turned_rad + math.tau * corner / corners for corner in range(corners)]
            ring = [
                (centre_m[0] + radius_m * math.cos(b), centre_m[1] + radius_m * math.sin(b)) for b in bearings
            ]
            return Polygon(vertices_m=tuple(ring))


def least_clearance_m(shapes: list[Shape], lengths_m: np.ndarray) -> np.ndarray:
    """The true clearance of the hull along a step in each heading."""
    ends = lengths_m[:, None] * np.stack([np.cos(HEADINGS_RAD), np.sin(HEADINGS_RAD)], axis=1)
    return clearance(ground_of(shapes), np.zeros_like(ends), ends) - ROBOT.robot_radius_m


@given(scenes())
@settings(max_examples=examples(60))
def test_every_certified_step_keeps_epsilon(shapes: list[Shape]) -> None:
    walls = scan_walls(look_around(shapes, ROBOT), ROBOT)
    lengths = np.minimum(certified_lengths_m(NOWHERE, HEADINGS_RAD, walls), ROBOT.range_m_max)
    assert (least_clearance_m(shapes, lengths) >= ROBOT.epsilon_m - 1e-9).all()


@given(scenes(), st.sampled_from(range(len(HEADINGS_RAD))))
@settings(max_examples=examples(60))
def test_every_step_keeps_its_promised_clearance(shapes: list[Shape], heading: int) -> None:
    view = look_around(shapes, ROBOT)
    lengths = certified_lengths_m(NOWHERE, HEADINGS_RAD, scan_walls(view, ROBOT))
    length_m = min(float(lengths[heading]), ROBOT.range_m_max)
    target = length_m * np.array([np.cos(HEADINGS_RAD[heading]), np.sin(HEADINGS_RAD[heading])])
    nobody = np.zeros(len(view.hits), dtype=np.bool_)
    promised_m = promised_clearance_m(view, target, nobody, ROBOT)
    kept_m = float(least_clearance_m(shapes, np.full(len(HEADINGS_RAD), length_m))[heading])
    assert promised_m >= ROBOT.epsilon_m - 1e-6
    assert kept_m >= promised_m - 1e-9


@given(scenes())
@settings(max_examples=10)
def test_the_ground_that_a_scan_is_sure_of_has_an_edge_all_around(shapes: list[Shape]) -> None:
    walls = scan_walls(look_around(shapes, ROBOT), ROBOT)
    starts, ends = ({tuple(corner) for corner in np.round(each, 9)} for each in (walls.starts, walls.ends))
    assert starts == ends
    assert len(walls.starts) >= ROBOT.directions


@given(scenes())
@settings(max_examples=examples(30), deadline=None)
def test_no_step_beyond_the_seen_region_is_certified(shapes: list[Shape]) -> None:
    view = look_around(shapes, ROBOT)
    lengths = certified_lengths_m(NOWHERE, view.bearings_rad, scan_walls(view, ROBOT))
    assert (lengths <= view.ranges_m - KEEP_M + 1e-9).all()


def test_in_the_open_a_step_ends_before_the_range_limit() -> None:
    walls = scan_walls(look_around([], ROBOT), ROBOT)
    sure_m = ROBOT.sure_share_in(720) * ROBOT.range_m_max
    lengths = certified_lengths_m(NOWHERE, HEADINGS_RAD, walls)
    assert lengths == pytest.approx(sure_m - KEEP_M, abs=1e-3)


def test_an_opening_too_narrow_for_robot_and_clearance_is_not_entered() -> None:
    shapes: list[Shape] = [wall((1.0, 3.0), (1.0, 0.19)), wall((1.0, -0.19), (1.0, -3.0))]
    walls = scan_walls(look_around(shapes, ROBOT), ROBOT)
    assert certified_lengths_m(NOWHERE, np.array([0.0]), walls)[0] < 0.95


def test_an_opening_that_is_wide_enough_is_passed() -> None:
    shapes: list[Shape] = [wall((1.0, 3.0), (1.0, 0.24)), wall((1.0, -0.24), (1.0, -3.0))]
    walls = scan_walls(look_around(shapes, ROBOT), ROBOT)
    assert certified_lengths_m(NOWHERE, np.array([0.0]), walls)[0] > 1.5


@pytest.mark.parametrize(
    ("degrees", "half_width_m", "goes_on"), [(1.0, 0.212, True), (0.6, 0.212, False), (10.0, 0.1999, False)]
)
def test_a_short_step_comes_nearer_to_what_may_be_hidden_but_not_to_what_was_hit(
    degrees: float, half_width_m: float, goes_on: bool
) -> None:
    """Of 0.2105 m to the wall, 7,200 rays may miss 5 % beside 1 degree, and 8.3 % beside 0.6."""
    noisy = replace(ROBOT, sharpest_corner_rad=math.radians(degrees), range_error_m_max=0.0015)
    walls: list[Shape] = [
        wall((-3.0, half_width_m), (3.0, half_width_m)),
        wall((3.0, -half_width_m), (-3.0, -half_width_m)),
    ]
    view = look_around(walls, noisy, revolutions=10)
    ahead, nobody = np.array([0.0]), np.zeros(len(view.hits), dtype=np.bool_)
    assert certified_lengths_m(NOWHERE, ahead, scan_walls(view, noisy))[0] < 0.01
    short_m = float(certified_lengths_m(NOWHERE, ahead, short_step_walls(view, noisy))[0])
    assert (short_m > 0.25) is goes_on
    promised_m = promised_clearance_m(view, np.array([short_m, 0.0]), nobody, noisy)
    least_m = noisy.epsilon_m - noisy.mu0_m / 2.0 - 1e-6
    assert promised_m >= least_m or short_m < 0.01


def test_an_edge_that_is_too_near_only_forbids_motion_towards_it() -> None:
    near: list[Shape] = [wall((0.15, 0.5), (0.15, -0.5))]
    walls = scan_walls(look_around(near, ROBOT), ROBOT)
    towards_m, away_m = certified_lengths_m(NOWHERE, np.array([0.0, np.pi]), walls)
    assert towards_m == 0.0
    assert away_m > 1.0


def test_a_step_leads_away_from_all_that_is_too_near_up_to_the_last_ray_that_meets_it() -> None:
    """Without the sides, the ground beside that ray would forbid half the angle between two rays less."""
    post: list[Shape] = [Circle(centre_m=(KEEP_M + 0.05, 0.0), radius_m=0.1)]
    view = look_around(post, ROBOT)
    seen = sure(view, ROBOT)
    corners = np.concatenate([seen.starts, seen.ends])
    off_m = np.hypot(*corners.T)
    near = corners[off_m < KEEP_M] / off_m[off_m < KEEP_M, None]
    headings_rad = np.linspace(-np.pi, np.pi, 7200, endpoint=False)  # each tenth of what two rays are apart
    free = certified_lengths_m(NOWHERE, headings_rad, scan_walls(view, ROBOT)) > 0.0
    away = -(unit_vectors(headings_rad) @ near.T).max(axis=1)
    least = math.sin(ROBOT.drive_off_rad)
    assert away[free].min() >= least - 1e-9
    assert free[away > least + 1e-6].all()


def test_what_is_left_out_leaves_an_opening_that_the_neighbouring_rays_bound() -> None:
    post: list[Shape] = [Circle(centre_m=(1.0, 0.0), radius_m=0.5)]
    view = look_around(post, ROBOT)
    walls = scan_walls(view, ROBOT, leave_out=view.hits)
    corners = np.concatenate([walls.starts, walls.ends])
    assert np.hypot(*corners.T).min() > 0.9 * ROBOT.range_m_max
    assert certified_lengths_m(NOWHERE, np.array([0.0]), walls)[0] > 2.0


def test_an_edge_that_reaches_far_away_is_narrower_near_the_obstacle() -> None:
    shapes: list[Shape] = [wall((1.0, 3.0), (1.0, 0.22)), wall((1.0, -0.22), (1.0, -3.0))]
    walls = scan_walls(look_around(shapes, ROBOT), ROBOT)
    unsure_m = (1.0 - ROBOT.sure_share_in(720)) * ROBOT.range_m_max
    assert unsure_m > 0.02, "with the width of its far end it would close the opening"
    assert certified_lengths_m(NOWHERE, np.array([0.0]), walls)[0] > 1.2


def test_a_wider_range_error_makes_steps_shorter() -> None:
    shapes: list[Shape] = [wall((1.0, 1.0), (1.0, -1.0))]
    view = look_around(shapes, ROBOT)
    sharp = certified_lengths_m(NOWHERE, np.array([0.0]), scan_walls(view, ROBOT))
    blurred = under("certified", robot_radius_m=0.1, range_error_m_max=0.05)
    dull = certified_lengths_m(NOWHERE, np.array([0.0]), scan_walls(view, blurred))
    assert dull[0] < sharp[0] - 0.04


@given(st.floats(0.5, 3.0), st.floats(-1.5, 1.5))
def test_a_step_keeps_its_distance_from_ground_that_robots_behind_may_reach(x_m: float, y_m: float) -> None:
    assume(np.hypot(x_m, y_m) > 0.4)
    there = ground_walls(np.array([[x_m, y_m], [x_m, y_m + 1.0]]), keep_m=0.3)
    bearing_rad = np.array([np.arctan2(y_m, x_m)])
    assert certified_lengths_m(NOWHERE, bearing_rad, there)[0] <= np.hypot(x_m, y_m) - 0.3 + 1e-9


def test_the_hull_stays_inside_the_bounds() -> None:
    bounds = Bounds(x_m_min=-1.0, y_m_min=-2.0, x_m_max=3.0, y_m_max=4.0)
    free = certified_lengths_m(
        NOWHERE, np.array([0.0, np.pi / 2, np.pi, -np.pi / 2]), bounds_walls(bounds, ROBOT)
    )
    margin_m = ROBOT.robot_radius_m + ROBOT.mu0_m
    assert free == pytest.approx(np.array([3.0, 4.0, 1.0, 2.0]) - margin_m)


def test_joined_walls_contain_all_segments() -> None:
    one = ground_walls(np.array([[1.0, -1.0], [1.0, 1.0]]), keep_m=0.1)
    other = ground_walls(np.array([[-1.0, -1.0], [-1.0, 1.0]]), keep_m=0.2)
    free = certified_lengths_m(NOWHERE, np.array([0.0, np.pi]), Walls.joined(one, other))
    assert free == pytest.approx([0.9, 0.8])


def test_the_promise_covers_an_obstacle_of_which_one_ray_shows_beside_a_robot() -> None:
    shapes: list[Shape] = [wall((1.5, 1.0), (1.5, -1.0))]
    view = look_around(shapes, ROBOT)
    lone = int(np.flatnonzero(view.hits)[len(np.flatnonzero(view.hits)) // 2])
    robots = view.hits.copy()
    robots[lone] = False
    promised_m = promised_clearance_m(view, np.array([-0.5, 0.0]), robots, ROBOT)
    assert promised_m == pytest.approx(1.5 - ROBOT.robot_radius_m, abs=0.03)


def test_the_promise_covers_an_obstacle_that_a_robot_hides() -> None:
    hull = Circle(centre_m=(0.5, 0.0), radius_m=ROBOT.robot_radius_m)
    hidden_m = 0.5 + ROBOT.robot_radius_m + ROBOT.epsilon_m
    view = look_around([hull, wall((hidden_m, 0.05), (hidden_m, -0.05))], ROBOT)
    promised_m = promised_clearance_m(view, np.array([-0.5, 0.0]), view.hits, ROBOT)
    assert 0.4 < promised_m <= hidden_m - ROBOT.robot_radius_m, "the hull's own clearance is 0.3 m"


@given(
    st.sampled_from([-1.0, 1.0]),
    st.floats(0.1, 3.9),
    st.floats(0.8, 1.6),
    st.floats(2.2, 3.8),
    st.floats(5.0, 40.0),
)
def test_no_promise_exceeds_the_true_clearance_where_a_robot_stands_far_behind_an_obstacles_tip(
    side: float, edge_deg: float, post_m: float, hull_m: float, heading_deg: float
) -> None:
    coarse = under("certified", robot_radius_m=0.1, directions=90)
    bearing_rad = math.radians(edge_deg) + math.asin(0.2 / post_m)
    centre_m = (post_m * math.cos(bearing_rad), post_m * side * math.sin(bearing_rad))
    post, hull = Circle(centre_m=centre_m, radius_m=0.2), Circle(centre_m=(hull_m, 0.0), radius_m=0.1)
    view = look_around([post, hull], coarse)
    robots = view.hits & (view.ranges_m > 2.0)
    assert robots.any(), "a ray beside the post's edge meets the robot"
    target = 2.0 * np.array(
        [math.cos(math.radians(heading_deg)), -side * math.sin(math.radians(heading_deg))]
    )
    kept_m = float(clearance(ground_of([post]), np.zeros((1, 2)), target[None])[0]) - coarse.robot_radius_m
    assert promised_clearance_m(view, target, robots, coarse) <= max(0.0, kept_m)
