"""A substitute for a scenario that a log does not hold: point robots on empty ground, without promises.

Rule 1: only the number of robots and their first places are drawn; both come from the log.
"""

import msgspec

from clew.log.timeline import Timeline
from protocol.timeline import PoseSampled
from world.scenario.scenario import Scenario

LAWFUL = {
    "name": "unknown",
    "law": {"law": "printed", "epsilon_m": 0.1, "mu0_m": 0.01},
    "sensor": {"directions": 360, "range_m_max": 1.0, "range_sigma_m": 0.0},
    "drive": {
        "speed_mps": 0.5,
        "speed_mps_min": 0.05,
        "speed_mps_max": 1.0,
        "turn_rate_radps": 1.0,
        "heading_error_rad": 0.0,
    },
    "time": {"time_s_max": 300.0},
    "switching_positions_max": 2,
}
"""The required fields of a scenario; see rule 1."""


def stand_in(read: Timeline) -> Scenario | None:
    """The substitute for the robots that were seen; None if there were none."""
    starts: dict[int, tuple[float, float, float]] = {}
    for _, entry in read.lines:
        if isinstance(entry.record, PoseSampled):
            pose = entry.record
            starts.setdefault(pose.robot, (pose.x_m, pose.y_m, pose.heading_rad))
    if not starts:
        return None
    places = [starts.get(robot, starts[max(starts)]) for robot in range(1, max(starts) + 1)]
    fleet = {
        "robots": len(places),
        "robot_radius_m": 0.0,
        "separation_m": 0.0,
        "link_length_m_max": 1.0,
        "places": places,
    }
    return msgspec.convert({**LAWFUL, "fleet": fleet}, Scenario)
