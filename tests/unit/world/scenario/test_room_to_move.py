"""A fleet in which nobody could move, or join a strand, is refused: without a fault it would never end."""

from typing import Any

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.errors import UsageError
from tests.support.scenes.placed import placed, polygon
from world.judge.ending import Ending
from world.scenario.scenario import Scenario

WALL = polygon((0.0, 0.5), (6.0, 0.5), (6.0, 1.0), (0.0, 1.0))


def scenario(
    *obstacles: dict[str, Any], fleet: dict[str, Any] | None = None, **sections: dict[str, Any] | float
) -> Scenario:
    """Two robots in a queue, with these sections changed."""
    queue = {"robots": 2, "link_length_m_max": 1.0, "start": (2.0, 2.0, 0.0), "spacing_m": 0.4}
    usual = {"law": {"epsilon_m": 0.05, "mu0_m": 0.01}, "sensor": {"range_m_max": 3.0}}
    return placed("room", (), (3.0, 2.0), *obstacles, fleet=queue | (fleet or {}), **(usual | sections))


@pytest.mark.parametrize("directions", [36, 60, 120, 360])
def test_robots_that_start_as_near_to_each_other_as_is_accepted_beside_fast_obstacles_can_move(
    directions: int,
) -> None:
    """What two rays may hide counts: 36 to 120 of them once let robots start so near that all stood."""
    sensor = {"directions": directions, "range_m_max": 3.0}
    sight = scenario(obstacle_speed_mps_max=1.0, sensor=sensor).mission()
    nearest = {"spacing_m": sight.moves_beside_m + 1e-6}
    accepted = scenario(obstacle_speed_mps_max=1.0, sensor=sensor, fleet=nearest)
    assert Rehearsal(accepted, seed=1).run().world.ending is Ending.ARRIVED
    nearer = {"spacing_m": sight.moves_beside_m - 1e-6}
    with pytest.raises(UsageError, match="none can move"):
        scenario(obstacle_speed_mps_max=1.0, sensor=sensor, fleet=nearer)


def test_a_robot_that_starts_too_near_to_an_obstacle_to_move_where_others_are_fast_is_refused() -> None:
    at_wall = {"robots": 1, "start": [2.0, 1.15, 0.0]}
    still = scenario(WALL, fleet=at_wall)
    assert Rehearsal(still, seed=1).run().world.ending is Ending.ARRIVED
    with pytest.raises(UsageError, match=r"place of robot 1: must be >= 0.16\d* m away from \$.obstacle"):
        scenario(WALL, fleet=at_wall, obstacle_speed_mps_max=1.0)
    off_wall = at_wall | {"start": [2.0, 1.17, 0.0]}
    fast = scenario(WALL, fleet=off_wall, obstacle_speed_mps_max=1.0)
    assert Rehearsal(fast, seed=1).run().world.ending is Ending.ARRIVED


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        (
            {"fleet": {"link_length_m_max": 0.26}},
            r"\$.fleet.link_length_m_max: must be >= 0.28 m, the least way between neighbours, got 0.26",
        ),
        (
            {"fleet": {"spacing_m": 2.0}, "obstacle_speed_mps_max": 20.0},
            r"\$.fleet.link_length_m_max: must be >= .* where obstacles move at 20 m/s, got ",
        ),
        (
            {"fleet": {"separation_m": 0.2, "spacing_m": 0.42}, "sensor": {"range_m_max": 0.4}},
            r"\$.sensor: must be sure of 0.43 m, the least way between neighbours, got 0.2643 m",
        ),
        (
            {"fleet": {"link_length_m_max": 0.3}, "law": {"epsilon_m": 0.005, "mu0_m": 0.001}},
            r"\$.law.epsilon_m: must be more: on every way of up to 0.3 m the robot ahead hides what",
        ),
    ],
)
def test_a_fleet_whose_robots_could_join_a_strand_nowhere_is_refused(
    changed: dict[str, Any], line: str
) -> None:
    """Each such fleet searched for places until the time was up, or left all robots but one behind."""
    with pytest.raises(UsageError, match=line):
        scenario(**changed)
    alone = changed | {"fleet": changed["fleet"] | {"robots": 1}}
    assert scenario(**alone).fleet.robots == 1


def test_robots_find_places_that_only_a_closer_look_shows() -> None:
    """Nearer, the robot ahead hides what is beside it; there, a scan of the usual rays does not show that."""
    thin = {"epsilon_m": 0.01, "mu0_m": 0.002}
    wide = {"robot_radius_m": 0.2, "separation_m": 0.01, "spacing_m": 0.45, "link_length_m_max": 0.8}
    drawn = scenario(fleet=wide, law=thin, sensor={"directions": 720})
    assert Rehearsal(drawn, seed=1).run().world.ending is Ending.ARRIVED
