"""What hulls hide beside a leg: that of the robot ahead, and others."""

import math
from itertools import product

import numpy as np
import pytest
from msgspec.structs import replace

from agents.membership.legs import leg_is_clear, leg_needs_closer_look, without_hulls
from agents.navigation.leg import certain_clearance_m_min
from agents.navigation.scan import View
from protocol.arrays import distances_to_segments, scan_bearings_rad, unit_vectors
from protocol.legs import hull_hides
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M
from tests.support.long import long
from world.geometry.clearance import clearance, distances
from world.geometry.rays import cast
from world.geometry.shapes import Circle, Polygon, ground_of
from world.scenario.scenario import load

MISSION = replace(
    load("grove").mission(),
    robot_radius_m=0.2,
    epsilon_m=0.01,
    mu0_m=0.002,
    separation_m=0.005,
    directions=1440,
    revolutions=1,
    range_error_m_max=0.0,
)
POST_M = 0.004  # its radius: out to 1.8 m it fits between no two rays
PIN_M = 0.0005  # of a thinner one: out to 1.1 m it fits between no two of 7,200 rays
HERE = np.array([0.0, 0.0])
Place = tuple[float, float]


def sees(disc: np.ndarray, ahead: np.ndarray, radius_m: float = POST_M, mission: Mission = MISSION) -> View:
    """A scan from `HERE` of a post or a body, and of the robot ahead."""
    bearings = scan_bearings_rad(mission.directions)
    ground = ground_of((Circle(centre_m=(float(disc[0]), float(disc[1])), radius_m=radius_m),))
    hull = np.array([[*ahead, mission.robot_radius_m]])
    ranges = cast(ground, HERE, bearings, range_m_max=mission.range_m_max, discs=hull)
    view = View(HERE, bearings, ranges, ranges < mission.range_m_max, 0.0)
    return without_hulls(view, ahead[None], mission)


@pytest.mark.parametrize("leg_m", [0.407, 0.5, 0.7, 1.5, *long([0.45, 0.6, 0.8, 1.0])])
def test_on_a_clear_leg_no_post_is_too_near_that_the_robot_ahead_may_hide(leg_m: float) -> None:
    ahead = np.array([leg_m, 0.0])
    radius_m, promised_m = MISSION.robot_radius_m, MISSION.epsilon_m - MISSION.mu0_m
    off_m = radius_m + promised_m + 0.25 * MISSION.mu0_m + POST_M
    for turn_rad in np.linspace(0.0, math.pi / 2.0, 181):
        post = ahead + off_m * np.array([-math.sin(turn_rad), math.cos(turn_rad)])
        apart_m = float(distances_to_segments(post, HERE, ahead)) - POST_M - radius_m
        if leg_is_clear(sees(post, ahead), ahead, MISSION):
            assert apart_m >= promised_m, f"{math.degrees(turn_rad):.1f} degrees"


@pytest.mark.parametrize("leg_m", [0.43, 0.44, 0.45])
def test_on_a_clear_leg_no_post_is_too_near_to_a_robot_that_is_off_it_by_a_drives_error(leg_m: float) -> None:
    """The post is as near to the robot ahead as that may stand to it, and the range is short."""
    mission = replace(MISSION, epsilon_m=0.02, mu0_m=0.01, separation_m=0.02, range_m_max=0.51)
    mission = replace(mission, directions=7200)
    ahead, error_rad = np.array([leg_m, 0.0]), 0.25 * mission.mu0_m / mission.range_m_max
    radius_m, promised_m = mission.robot_radius_m, mission.epsilon_m - mission.mu0_m
    off_m = radius_m + promised_m + 0.25 * mission.mu0_m + PIN_M
    end = leg_m * np.array([math.cos(error_rad), math.sin(error_rad)])
    for turn_rad in np.linspace(0.0, math.pi / 4.0, 181):
        post = ahead + off_m * np.array([-math.sin(turn_rad), math.cos(turn_rad)])
        apart_m = float(distances_to_segments(post, HERE, end)) - PIN_M - radius_m
        if leg_is_clear(sees(post, ahead, PIN_M, mission), ahead, mission):
            assert apart_m >= promised_m, f"{math.degrees(turn_rad):.1f} degrees"


@pytest.mark.parametrize("leg_m", [0.46, 0.48, 0.53, 0.6])
def test_on_a_clear_leg_no_post_is_too_near_that_a_lid_over_the_robot_ahead_may_hide(leg_m: float) -> None:
    """An obstacle that moves may stand over a robot: it counts as the hull, and hides more."""
    mission = replace(MISSION, epsilon_m=0.02, mu0_m=0.01, separation_m=0.02, range_m_max=0.8)
    mission = replace(mission, directions=7200, obstacle_speed_mps_max=0.02)
    ahead, promised_m = np.array([leg_m, 0.0]), mission.epsilon_m - mission.mu0_m
    off_m = mission.robot_radius_m + promised_m + 0.25 * mission.mu0_m + PIN_M
    lid = np.array([[*ahead, mission.hull_reach_m - 1e-4]])
    bearings = scan_bearings_rad(mission.directions)
    for turn_rad in np.linspace(0.0, math.pi / 4.0, 91):
        post = ahead + off_m * np.array([-math.sin(turn_rad), math.cos(turn_rad)])
        ground = ground_of((Circle(centre_m=(float(post[0]), float(post[1])), radius_m=PIN_M),))
        ranges = cast(ground, HERE, bearings, range_m_max=mission.range_m_max, discs=lid)
        view = View(HERE, bearings, ranges, ranges < mission.range_m_max, 0.0)
        apart_m = float(distances_to_segments(post, HERE, ahead)) - PIN_M - mission.robot_radius_m
        if leg_is_clear(without_hulls(view, ahead[None], mission), ahead, mission):
            assert apart_m >= promised_m, f"{math.degrees(turn_rad):.1f} degrees"


@pytest.mark.parametrize("separation_m", [0.0, 0.03, *long([0.02])])
def test_on_a_clear_leg_no_body_is_too_near_that_the_robot_ahead_may_hide_however_near_it_stands_to_that(
    separation_m: float,
) -> None:
    """The separation is far below epsilon, which is as near to mu0 as the loader allows."""
    mission = replace(MISSION, epsilon_m=0.05, mu0_m=0.025, separation_m=separation_m, directions=360)
    radius_m, promised_m = mission.robot_radius_m, max(separation_m - mission.mu0_m, 0.0)
    off_m = 2.0 * radius_m + promised_m
    clear: list[float] = []
    for leg_m in np.linspace(0.43, 2.0, 15).tolist():
        ahead = np.array([leg_m, 0.0])
        for turn_rad in (-1.5, -1.0, *np.linspace(0.0, 0.6, 40)):
            body = ahead + off_m * np.array([-math.sin(turn_rad), math.cos(turn_rad)])
            is_apart = math.hypot(*body) >= 2.0 * radius_m
            if is_apart and leg_is_clear(sees(body, ahead, radius_m, mission), ahead, mission):
                clear.append(float(distances_to_segments(body, HERE, ahead)) - 2.0 * radius_m)
    assert clear, "a body behind the robot ahead is in nobody's way"
    assert min(clear) >= promised_m - TOUCHING_M


def test_from_further_off_the_robot_ahead_hides_nothing_and_the_leg_may_be_clear() -> None:
    hides = [hull_hides(leg_m, MISSION.directions, MISSION) for leg_m in (0.41, 0.5, 0.6, 0.8, 1.5)]
    assert hides == [True, True, True, False, False]
    wide = replace(MISSION, epsilon_m=0.15 * MISSION.robot_radius_m)
    assert not any(hull_hides(leg_m, wide.directions, wide) for leg_m in np.linspace(0.41, 3.0, 50).tolist())
    ahead = np.array([0.8, 0.0])
    assert leg_is_clear(sees(np.array([0.8, 1.0]), ahead), ahead, MISSION)


def test_a_leg_that_few_rays_beside_the_hull_ahead_leave_unsure_is_looked_at_closer() -> None:
    ahead = np.array([2.05, 0.0])
    view = sees(np.array([2.05, 1.0]), ahead)
    assert hull_hides(2.05, MISSION.directions, MISSION)
    assert not hull_hides(2.05, 4 * MISSION.directions, MISSION)
    far = replace(MISSION, link_length_m_max=3.0)
    assert (leg_is_clear(view, ahead, far), leg_needs_closer_look(view, ahead, far)) == (False, True)
    near = np.array([0.45, 0.0])
    assert not leg_needs_closer_look(sees(np.array([0.45, 1.0]), near), near, MISSION), "no look shows more"


COARSE = replace(
    MISSION,
    robot_radius_m=0.1,
    epsilon_m=0.1,
    mu0_m=0.02,
    separation_m=0.05,
    directions=80,
    range_m_max=2.4,
    link_length_m_max=2.0,
)
AHEAD = np.array([1.3, 0.0])


def box_beside(ray: int, from_m: float) -> Polygon:
    """A box with a corner just beside this ray from `HERE`, and a side along it, so that the ray passes."""
    along, across = unit_vectors(np.array([0.0, math.pi / 2.0]) + ray * math.tau / COARSE.directions)
    low = from_m * along + 1e-3 * across
    corners = [low, low + 0.2 * along, low + 0.2 * along + 0.2 * across, low + 0.2 * across]
    return Polygon(vertices_m=tuple((float(x_m), float(y_m)) for x_m, y_m in corners))


def is_seen_clear(box: Polygon, beside: np.ndarray) -> bool:
    """Whether the leg is clear beside this box and a robot, which keep from each other what they have to."""
    robots, ground = np.array([beside, AHEAD]), ground_of((box,))
    keep_m = COARSE.robot_radius_m + COARSE.epsilon_m
    if min(distances(ground, each)[0] for each in robots) < keep_m:
        return False
    discs = np.column_stack((robots, np.full(2, COARSE.robot_radius_m)))
    bearings = scan_bearings_rad(COARSE.directions)
    ranges = cast(ground, HERE, bearings, range_m_max=COARSE.range_m_max, discs=discs)
    view = View(HERE, bearings, ranges, ranges < COARSE.range_m_max, 0.0)
    return leg_is_clear(without_hulls(view, robots, COARSE), AHEAD, COARSE)


def test_on_a_clear_leg_no_corner_is_too_near_that_a_robot_beside_the_leg_may_hide() -> None:
    """What a hull hides may reach out of its shadow up to the next ray."""
    tried = product((2, 3, 4), np.linspace(1.0, 1.1, 6).tolist(), np.linspace(0.7, 0.9, 11), (0.3, 0.4))
    clear = [
        float(clearance(ground_of((box,)), HERE[None], AHEAD[None])[0])
        for box, place in ((box_beside(ray, from_m), place) for ray, from_m, *place in tried)
        if is_seen_clear(box, np.array(place))
    ]
    assert clear, "what is hidden far off is in nobody's way"
    assert min(clear) - COARSE.robot_radius_m >= certain_clearance_m_min(COARSE)


@pytest.mark.parametrize(
    ("budget_m", "ahead", "beside", "pin", "post"),
    [
        ((0.088, 0.035), (0.8103, 0.0), (0.6564, 0.2694), (0.7048, 0.1459), (0.7624, 0.156)),
        # So near to the leg's end that it may count as on the leg, where the robot ahead keeps off obstacles.
        ((0.08124, 0.03905), (0.799, 0.0), (0.6555, 0.2642), (0.6804, 0.1366), (0.7437, 0.1493)),
    ],
)
def test_on_a_leg_beside_which_a_pin_that_moves_counts_as_hull_a_post_behind_the_pin_is_not_missed(
    budget_m: tuple[float, float], ahead: Place, beside: Place, pin: Place, post: Place
) -> None:
    """The pin stands behind the hull of a robot beside the leg, near enough to count as that hull."""
    epsilon_m, mu0_m = budget_m
    kept = {"epsilon_m": epsilon_m, "mu0_m": mu0_m, "separation_m": epsilon_m, "range_m_max": 0.833}
    mission = replace(COARSE, **kept, directions=7200, obstacle_speed_mps_max=0.01, watch_s=0.06)
    promised_m, drive_m, thin_m = epsilon_m - mu0_m, 0.25 * mu0_m, 0.001
    robots = np.array([ahead, beside])
    kept_m = np.hypot(*(robots - post).T) - thin_m - mission.robot_radius_m
    assert (kept_m >= (promised_m + drive_m, promised_m)).all(), "the robots may stand where they do"
    apart_m = float(distances_to_segments(np.array(post), HERE, robots[0])) - thin_m - mission.robot_radius_m
    assert apart_m < promised_m + drive_m * ahead[0] / mission.range_m_max
    posts = Circle(centre_m=post, radius_m=thin_m), Circle(centre_m=pin, radius_m=3.0 * thin_m)
    discs = np.column_stack((robots, np.full(2, mission.robot_radius_m)))
    bearings = scan_bearings_rad(mission.directions)
    ranges = cast(ground_of(posts), HERE, bearings, range_m_max=mission.range_m_max, discs=discs)
    view = View(HERE, bearings, ranges, ranges < mission.range_m_max, 0.0)
    assert not leg_is_clear(without_hulls(view, robots, mission), robots[0], mission)


def test_on_a_clear_leg_no_box_is_too_near_that_a_robot_beside_it_and_what_moves_there_may_hide() -> None:
    """Where obstacles move, one may stand behind a hull, count as that, and hide what is just behind it."""
    mission = replace(MISSION, epsilon_m=0.0737, mu0_m=0.0336, separation_m=0.0737, directions=582)
    mission = replace(mission, range_m_max=4.0, link_length_m_max=4.0, obstacle_speed_mps_max=0.001)
    beside, ahead, tilt_rad = np.array([2.577, 0.469]), np.array([2.775, 0.0]), 0.05
    passes_rad, hits_rad = np.array([8, 9]) * math.tau / mission.directions
    turned = unit_vectors(passes_rad + tilt_rad + np.array([0.0, math.pi / 2.0]))
    low = 2.744 * unit_vectors(passes_rad) + 1e-6 * unit_vectors(passes_rad + math.pi / 2.0)
    corners = low + 0.045 * np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) @ turned
    ground = ground_of((Polygon(vertices_m=tuple((float(x_m), float(y_m)) for x_m, y_m in corners)),))
    promised_m = mission.robot_radius_m + mission.epsilon_m - mission.mu0_m
    assert min(distances(ground, each)[0] for each in (beside, ahead)) >= promised_m
    assert clearance(ground, HERE[None], ahead[None])[0] < promised_m - 0.1 * mission.mu0_m
    hulls = [[*beside, mission.robot_radius_m], [*ahead, mission.robot_radius_m]]
    discs = np.array([*hulls, [*2.714 * unit_vectors(hits_rad), 0.022]])
    bearings = scan_bearings_rad(mission.directions)
    ranges = cast(ground, HERE, bearings, range_m_max=mission.range_m_max, discs=discs)
    view = View(HERE, bearings, ranges, ranges < mission.range_m_max, 0.0)
    assert not leg_is_clear(without_hulls(view, np.array([beside, ahead]), mission), ahead, mission)


def test_a_leg_to_a_point_is_not_clear_of_the_post_beside_that_point_which_no_ray_meets() -> None:
    """A robot of radius 0: the post stands on the leg, as near to the robot ahead as a hull would reach."""
    mission = replace(MISSION, robot_radius_m=0.0, epsilon_m=0.1, mu0_m=0.06, separation_m=0.0)
    ahead, post = np.array([1.0, 0.0]), np.array([0.95, 0.0])
    promised_m = mission.epsilon_m - mission.mu0_m
    assert promised_m <= np.hypot(*(ahead - post)) - POST_M < mission.mu0_m, "the robot may stand there"
    assert not leg_is_clear(sees(post, ahead, mission=mission), ahead, mission)
