"""How much work it takes until a fleet drives as one strand: queues of different lengths, rehearsed.

Rule 1: a run ends at the end of the tick in which the last robot has joined; its CPU time is counted up to
        there, without the making of the rehearsal.
Rule 2: messages are counted where they are sent. A robot's share must not grow with the fleet; that of the
        coordinator, which answers everybody, does.
"""

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.keys import robot_number
from protocol.timeline import StrandFormed, StrandJoined
from world.scenario.scenario import Scenario

Clock = Callable[[], float]

SEED = 1
FLEETS = (5, 50, 200, 1000)
BOUND_ROBOTS, BOUND_CPU_S = 200, 10.0  # a queue of 200 robots forms in ten seconds of CPU time
SPACING_M = 0.3
PATIENCE_S = 60.0  # simulated; a queue forms in one

QUEUE: dict[str, Any] = {
    "name": "queue",
    "fleet": {"robot_radius_m": 0.1, "separation_m": 0.05, "link_length_m_max": 1.0, "spacing_m": SPACING_M},
    "law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.01},
    "sensor": {"directions": 1440, "range_m_max": 4.0, "range_sigma_m": 0.001},
    "drive": {
        "speed_mps": 0.5,
        "speed_mps_min": 0.05,
        "speed_mps_max": 1.0,
        "turn_rate_radps": 1.5708,
        "heading_error_rad": 0.0003,
    },
    "time": {"time_s_max": 600.0},
    "obstacle": [],
}


class Forming(Struct, frozen=True, kw_only=True):
    """How one fleet formed."""

    robots: int
    formed_s: float | None
    """Simulated time until all had joined; None: they did not."""
    cpu_s: float
    messages_per_robot: float
    """Sent by each robot that does not coordinate, in the mean."""
    coordinator_messages: int


def queue(robots: int) -> Scenario:
    """Robots in a straight queue on open ground, with the goal before them."""
    first_m = SPACING_M * robots + 4.0
    raw = {
        **QUEUE,
        "fleet": {**QUEUE["fleet"], "robots": robots, "start": [first_m, 1.5, 0.0]},
        "goal": {"at_m": [first_m + 3.5, 1.5], "tolerance_m": 0.15},
        "bounds": {"x_m_min": 0.0, "y_m_min": 0.0, "x_m_max": first_m + 8.0, "y_m_max": 3.0},
    }
    return msgspec.convert(raw, Scenario)


def forming(robots: int, *, cpu: Clock) -> Forming:
    """Rehearse a queue until it has formed."""
    rehearsal = Rehearsal(queue(robots), SEED)
    joined, seen, formed_s = 0, 0, None
    since_s = cpu()
    cpu_s = 0.0
    for now_s in rehearsal.ticks():
        joined += sum(isinstance(entry.record, StrandJoined) for _, entry in rehearsal.entries[seen:])
        seen = len(rehearsal.entries)
        if cpu_s == 0.0 and (joined == robots or now_s > PATIENCE_S):
            cpu_s, formed_s = cpu() - since_s, now_s if joined == robots else None
            rehearsal.stop(ExitCode.INTERRUPTED)
    makers = [source for source, entry in rehearsal.entries if isinstance(entry.record, StrandFormed)]
    coordinator = robot_number(makers[-1]) if makers else None
    settled = rehearsal.world.tally.settled
    sent = {robot: sum(each.sent.values()) for robot, each in settled.items()}
    others = [count for robot, count in sent.items() if robot != coordinator]
    return Forming(
        robots=robots,
        formed_s=formed_s,
        cpu_s=cpu_s,
        messages_per_robot=sum(others) / len(others) if others else 0.0,
        coordinator_messages=0 if coordinator is None else sent[coordinator],
    )


def figures(rows: Sequence[Forming]) -> list[Figure]:
    """The figures of some queues, each rehearsed once."""
    return [
        each
        for row in rows
        for each in (
            figure(
                f"{row.robots} robots: CPU time until formed",
                "s",
                [None if row.formed_s is None else row.cpu_s],
                aim=Aim(at_most=BOUND_CPU_S if row.robots <= BOUND_ROBOTS else None),
            ),
            figure(f"{row.robots} robots: messages per robot", "", [row.messages_per_robot]),
            figure(f"{row.robots} robots: messages of the coordinator", "", [row.coordinator_messages]),
        )
    ]
