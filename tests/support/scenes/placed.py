"""Scenarios by what is special of them: where robots stand, their goal, obstacles. Not a test file."""

from collections.abc import Sequence
from typing import Any

from protocol.files.reading import understand
from world.scenario.scenario import Scenario

Numbers = Sequence[float]


def placed(
    name: str, places: Sequence[Numbers], goal: Numbers, /, *obstacles: dict[str, Any], **sections: object
) -> Scenario:
    """A scenario that differs from the usual one by this.

    Args:
        name: its name.
        places: of the robots, `(x, y)` or `(x, y, heading)`; none: the section `fleet` says where they start.
        goal: `(x, y)`.
        obstacles: those that do not move.
        sections: their other fields; and fields of the scenario itself.

    Raises:
        UsageError: it is invalid.
    """
    raw: dict[str, Any] = {
        "name": name,
        "fleet": {
            "robots": len(places),
            "robot_radius_m": 0.1,
            "separation_m": 0.05,
            "link_length_m_max": 3.0,
            "places": [(*place, 0.0)[:3] for place in places] or None,
        },
        "law": {"epsilon_m": 0.1, "mu0_m": 0.02},
        "goal": {"at_m": goal, "tolerance_m": 0.1},
        "sensor": {"directions": 360, "range_m_max": 4.0},
        "drive": {"speed_mps": 0.5, "speed_mps_min": 0.05, "speed_mps_max": 1.0, "turn_rate_radps": 3.0},
        "time": {"time_s_max": 60.0},
        "obstacle": obstacles,
    }
    for section, fields in sections.items():
        raw[section] = raw.get(section, {}) | fields if isinstance(fields, dict) else fields
    return understand(raw, Scenario, name)


def circle(centre_m: Numbers, radius_m: float) -> dict[str, Any]:
    """An obstacle."""
    return {"shape": "circle", "centre_m": centre_m, "radius_m": radius_m}


def polygon(*vertices_m: Numbers) -> dict[str, Any]:
    """An obstacle."""
    return {"shape": "polygon", "vertices_m": vertices_m}
