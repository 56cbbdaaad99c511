"""Places behind the strand's end: which of them a robot that joins goes to."""

import numpy as np

from agents.membership.stands import Stands, places_behind
from agents.navigation.leg import certain_clearance_m_min
from protocol.arrays import distances_to_segments, unit_vectors
from tests.support.stages.one_step import under

NOBODY = np.zeros((0, 2))
AHEAD = np.zeros(2)
MISSION = under(
    "certified",
    robots=3,
    robot_radius_m=0.15,
    epsilon_m=0.05,
    mu0_m=0.005,
    directions=180,
    range_error_m_max=0.00125,
    link_length_m_max=1.5,
)


def test_a_body_that_died_as_near_as_robots_stand_leaves_places_beyond_the_robot_ahead() -> None:
    """Only the closest look permits a leg from there. Found where a leader had died at the goal."""
    shown_m = MISSION.robot_radius_m + MISSION.range_error_m_max  # each range too short, at worst
    hull = (-MISSION.robot_keep_m, 0.0) + shown_m * unit_vectors(np.linspace(-np.pi, np.pi, 400))
    places = places_behind(Stands(AHEAD[None], NOBODY, AHEAD[None], 0), hull, MISSION)
    assert len(places) > 100
    off_m = distances_to_segments(hull, places[:, None], AHEAD)
    assert off_m.min() >= MISSION.robot_radius_m + certain_clearance_m_min(MISSION)
