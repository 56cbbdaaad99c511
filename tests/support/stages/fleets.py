"""Scenarios with several fleets, and what becomes of them in a rehearsal."""

import math
from pathlib import Path
from typing import Any

import msgspec

from clew.rehearsal.fleets import RecordedFleets
from protocol.faults.plan import NO_FAULTS, Plan
from world.scenario.fleets import SharedGround

WEST_M, EAST_M, LANE_M = 1.2, 5.8, 1.5


def fleet(
    name: str, start: tuple[float, float, float], goal: tuple[float, float], robots: int = 2
) -> dict[str, Any]:
    """One fleet, in a queue."""
    return {
        "name": name,
        "robots": robots,
        "robot_radius_m": 0.1,
        "separation_m": 0.05,
        "link_length_m_max": 1.0,
        "start": start,
        "spacing_m": 0.3,
        "goal": {"at_m": goal, "tolerance_m": 0.3},
    }


HEAD_ON = (
    fleet("east", (WEST_M, LANE_M, 0.0), (EAST_M, LANE_M)),
    fleet("west", (EAST_M, LANE_M, math.pi), (WEST_M, LANE_M)),
)


def raw(*fleets: dict[str, Any], **more: object) -> dict[str, Any]:
    """A scenario file with these fleets in an open room, as a parser reads it."""
    return {
        "name": "meeting",
        "fleet": list(fleets or HEAD_ON),
        "law": {"epsilon_m": 0.1, "mu0_m": 0.01},
        "sensor": {"directions": 360, "range_m_max": 3.0, "range_sigma_m": 0.001},
        "drive": {
            "speed_mps": 0.5,
            "speed_mps_min": 0.05,
            "speed_mps_max": 1.0,
            "turn_rate_radps": 1.5708,
            "heading_error_rad": 0.0003,
        },
        "bounds": {"x_m_min": 0.0, "y_m_min": 0.0, "x_m_max": 7.0, "y_m_max": 3.0},
        "time": {"time_s_max": 200.0},
        **more,
    }


def shared(*fleets: dict[str, Any], **more: object) -> SharedGround:
    """The same, understood."""
    return msgspec.convert(raw(*fleets, **more), SharedGround)


def rehearsed(
    ground: SharedGround, folder: Path, *, seed: int = 1, plan: Plan = NO_FAULTS, until_s: float = math.inf
) -> RecordedFleets:
    """A rehearsal until it is judged, until this time, or until two fleets touch; its files are closed."""
    with RecordedFleets(ground, seed, folder, plan) as recorded:
        for now_s in recorded.ticks():
            if recorded.hulls.between.contacts or now_s >= until_s:
                return recorded
        recorded.judge()
    return recorded
