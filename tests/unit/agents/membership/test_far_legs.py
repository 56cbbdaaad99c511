"""A leg about as long as the range: what stands beside its far end is beyond the range of a scan."""

import math

import msgspec
import numpy as np

from agents.membership.legs import leg_is_clear, without_hulls
from agents.navigation.scan import view
from protocol.arrays import xy
from tests.support.scenes.world_scenarios import scenario
from world.bodies.arena import Arena
from world.geometry.clearance import clearance
from world.scenario.scenario import Scenario

RANGE_M, KEEP_M, POST_M = 1.0, 0.5, 0.02


def test_no_leg_is_clear_whose_far_end_a_scan_does_not_show() -> None:
    """A post beyond the range, `epsilon` from the robot ahead, is nearer than that to the way to it."""
    from_here_m, from_there_m = RANGE_M + POST_M + 0.001, KEEP_M + POST_M + 1e-6
    x_m = (from_here_m**2 - from_there_m**2 + RANGE_M**2) / (2.0 * RANGE_M)
    post = {
        "shape": "circle",
        "centre_m": [x_m, math.sqrt(from_here_m**2 - x_m**2)],
        "radius_m": POST_M,
    }
    raw = msgspec.to_builtins(scenario()) | {
        "fleet": {
            "robots": 2,
            "robot_radius_m": 0.2,
            "separation_m": 0.05,
            "link_length_m_max": 2.0,
            "places": [[RANGE_M, 0.0, 0.0], [0.0, 0.0, 0.0]],
        },
        "law": {"epsilon_m": 0.3, "mu0_m": 0.002},
        "sensor": {"directions": 7200, "range_m_max": RANGE_M},
        "obstacle": [post],
    }
    said = msgspec.convert(raw, Scenario)
    mission = said.mission()
    _, scan = Arena(said, seed=1).scan(2, mission.revolutions)
    places = np.array([xy(pose) for pose in said.fleet.poses()])
    seen = without_hulls(view(scan, range_m_max=mission.range_m_max), places, mission)
    passes_m = float(clearance(said.ground, places[1:], places[:1]).min()) - 0.2
    assert passes_m < said.law.epsilon_m - said.law.mu0_m, "the way breaks S1"
    assert not leg_is_clear(seen, places[0], mission)
