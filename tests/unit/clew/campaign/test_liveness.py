"""Sure ways to the goal by the full map (`clew/campaign/liveness.py`)."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from clew.campaign.liveness import SPARE_M, all_have_way
from tests.support.scenes.world_scenarios import scenario
from world.geometry.shapes import Polygon, Shape
from world.scenario.scenario import Scenario

THICK_M = 0.02
ELSEWHERE = (-3.0, 2.0)
GOAL = {"at_m": [5.0, 0.0], "tolerance_m": 0.3}
FLEET = {"robots": 3}
KEEP_M = scenario().closest_m
SURE_M = KEEP_M + SPARE_M


def wall(low_m: float, high_m: float) -> Shape:
    """A thin wall across the region, between two y."""
    return Polygon(vertices_m=((2.0, low_m), (2.0 + THICK_M, low_m), (2.0 + THICK_M, high_m), (2.0, high_m)))


def with_door(half_m: float) -> Scenario:
    """A region divided by a wall with a door; the goal is behind the wall."""
    walls = (wall(-3.0, -half_m), wall(half_m, 3.0))
    return replace(scenario(goal=GOAL, fleet=FLEET), obstacles=walls)


def has_way(half_m: float, *places: tuple[float, float]) -> bool:
    """Whether robot 1 has a way, with the other bodies at these places or elsewhere."""
    others = (*places[1:], *[ELSEWHERE] * (3 - len(places)))
    return all_have_way(with_door(half_m), np.array([places[0], *others]), (1,))


@pytest.mark.parametrize(("more_m", "surely"), [(0.05, True), (-0.05, False)])
def test_a_door_is_a_sure_way_only_with_space_to_spare(more_m: float, surely: bool) -> None:
    assert has_way(SURE_M + more_m, (0.0, 0.0)) is surely


def test_a_door_narrower_than_the_robots_present_clearance_is_no_way_even_from_nearby() -> None:
    narrow_m = KEEP_M + 0.02
    assert not has_way(narrow_m, (1.94, 0.0))
    assert has_way(narrow_m, (2.0 + THICK_M / 2.0, 0.02)), "a robot in the door can leave it on either side"


@pytest.mark.parametrize("off_m", [KEEP_M, SURE_M])
def test_a_robot_near_a_wall_or_a_body_can_get_away_from_it(off_m: float) -> None:
    beside_wall = (2.0 + THICK_M + off_m, 1.5)
    assert has_way(KEEP_M, beside_wall)
    radius_m = with_door(KEEP_M).fleet.robot_radius_m
    assert has_way(KEEP_M, (3.5, 0.0), (3.5 + radius_m + off_m, 0.0))


def test_a_body_in_the_door_leaves_no_way() -> None:
    wide_m = SURE_M + 0.05
    assert has_way(wide_m, (0.0, 0.0))
    assert not has_way(wide_m, (0.0, 0.0), (2.0, 0.0))


@pytest.mark.parametrize("apart_m", [0.01, 0.03, 0.06])
@pytest.mark.parametrize("heading_rad", np.linspace(0.0, math.pi, 7))
def test_a_robot_between_two_bodies_can_leave_sideways(apart_m: float, heading_rad: float) -> None:
    here, radius_m = np.array([4.0, 0.5]), with_door(KEEP_M).fleet.robot_radius_m
    beside_m = (KEEP_M + radius_m + apart_m) * np.array([math.cos(heading_rad), math.sin(heading_rad)])
    assert has_way(KEEP_M, (4.0, 0.5), tuple(here + beside_m), tuple(here - beside_m))
