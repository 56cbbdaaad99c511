"""A small scenario for the tests of the world: a post and a block, robots queued towards -x."""

from typing import Any

import msgspec

from world.scenario.scenario import Scenario

SPACING_M = 0.6


def scenario(*moving: dict[str, Any], **sections: dict[str, Any]) -> Scenario:
    """The scenario with these moving obstacles and these changed fields of its sections."""
    raw: dict[str, Any] = {
        "name": "small",
        "fleet": {
            "robots": 2,
            "robot_radius_m": 0.1,
            "separation_m": 0.1,
            "link_length_m_max": 3.0,
            "start": [0.0, 0.0, 0.0],
            "spacing_m": SPACING_M,
        },
        "law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.02},
        "sensor": {"directions": 720, "range_m_max": 3.0},
        "drive": {"speed_mps": 0.5, "speed_mps_min": 0.05, "speed_mps_max": 1.0, "turn_rate_radps": 3.0},
        "time": {"time_s_max": 60.0},
        "bounds": {"x_m_min": -4.0, "y_m_min": -3.0, "x_m_max": 6.0, "y_m_max": 3.0},
        "obstacle": [
            {"shape": "circle", "centre_m": [1.5, 0.6], "radius_m": 0.3},
            {"shape": "polygon", "vertices_m": [[2.0, -1.5], [3.0, -1.5], [3.0, -0.5], [2.0, -0.5]]},
        ],
    }
    raw["moving"] = moving
    for section, fields in sections.items():
        raw[section] = raw.get(section, {}) | fields
    return msgspec.convert(raw, Scenario)
