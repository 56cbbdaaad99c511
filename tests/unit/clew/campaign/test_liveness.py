"""Sure ways to the goal by the full map (`clew/campaign/liveness.py`)."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from clew.campaign.liveness import (
    SPARE_M,
    AtEnd,
    arrived_together,
    have_way,
    healed_at_s,
    liveness_failure,
    stranded,
)
from protocol.keys import WORLD
from protocol.timeline import PoseSampled, Record, RobotArrived, RobotStranded, StrandJoined
from tests.support.logs.logs import numbered
from tests.support.scenes.world_scenarios import scenario
from world.geometry.shapes import Polygon, Shape
from world.judge.ending import Ending
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
    return have_way(with_door(half_m), np.array([places[0], *others]), (1,)) == [1]


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


def test_a_robot_without_a_way_stands_in_the_way_of_the_one_behind_it() -> None:
    narrow = with_door(KEEP_M - 0.01)
    assert have_way(narrow, np.array([(0.0, 0.0), (4.0, 0.0), ELSEWHERE]), (1, 2)) == [2]
    wide = with_door(SURE_M + 0.05)
    assert have_way(wide, np.array([(0.0, 0.0), (4.0, 0.0), (2.0, 0.0)]), (1, 2)) == [2]
    assert have_way(wide, np.array([(0.0, 0.0), (4.0, 0.0), (2.0, 0.0)]), (1, 2, 3)) == [1, 2, 3]


@pytest.mark.parametrize("has_cleared_the_door_s", [2.5, 5.5])
def test_robots_that_a_live_robot_locks_in_when_the_faults_are_over_are_not_asked_to_arrive(
    has_cleared_the_door_s: float,
) -> None:
    at = [(1, (0.0, 0.0)), (3, ELSEWHERE), (2, (2.0, 0.0))]
    sampled = [
        (WORLD, PoseSampled(robot=robot, x_m=x_m, y_m=y_m, heading_rad=0.0)) for robot, (x_m, y_m) in at
    ]
    *early, (_, last) = numbered((*sampled, (WORLD, replace(sampled[-1][1], x_m=4.0))))
    entries = [*early, (WORLD, replace(last, t_s=has_cleared_the_door_s))]
    fleet = AtEnd(
        scenario=with_door(SURE_M + 0.05),
        places_m=np.array([(0.0, 0.0), (4.0, 0.0), ELSEWHERE]),
        living=frozenset({1, 2, 3}),
        untrue=frozenset(),
        ending=Ending.TIMED_OUT,
        over_s=90.0,
    )
    said = liveness_failure(fleet, entries, quiet_s=5.0, outside=frozenset({2}))
    assert (said is None) == (has_cleared_the_door_s > 5.0)


def joined(robot: int, epoch: int) -> tuple[str, Record]:
    return f"r{robot}", StrandJoined(epoch=epoch, rank=0)


def test_a_core_is_healed_when_all_of_it_has_joined_one_strand_after_the_faults() -> None:
    apart = numbered((joined(1, 10_001), joined(2, 10_001), joined(1, 20_001), joined(2, 20_001)))
    assert healed_at_s(apart, (1, 2), 1.0) == 1.0
    assert healed_at_s(apart, (1, 2), 2.5) == 3.0
    assert healed_at_s(apart[:3], (1, 2), 2.5) == math.inf
    assert healed_at_s(apart, (1, 2, 3), 0.0) == math.inf


def test_a_robot_that_joins_a_strand_anew_has_not_arrived_yet() -> None:
    arrived = RobotArrived(progress_m=1.0)
    told = numbered((("r1", arrived), joined(1, 20_001), ("r2", arrived), ("r1", arrived)))
    assert arrived_together(told, (1, 2))
    assert not arrived_together(told[:3], (1, 2))


def test_an_arrival_that_poses_do_not_show_is_none() -> None:
    arrived = RobotArrived(progress_m=1.0)
    told = numbered((("r1", arrived), ("r2", arrived)))
    assert arrived_together(told, (1, 2), untrue=frozenset({3}))
    assert not arrived_together(told, (1, 2), untrue=frozenset({2}))


def test_a_robot_is_stranded_until_it_joins_a_strand() -> None:
    told = numbered((("r1", RobotStranded(epoch=10_001, robot=3, reason="no way")), joined(3, 20_001)))
    assert stranded(told[:1]) == {3: "no way"}
    assert stranded(told) == {}
