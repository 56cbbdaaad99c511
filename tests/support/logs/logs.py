"""Logs for tests, written by the recorder itself."""

from collections.abc import Sequence
from pathlib import Path

import msgspec

from protocol.timeline import Entry, PoseSampled, Record, RunEnded
from protocol.timeline.invariants import INVARIANTS
from world.judge.books import Messages
from world.judge.verdict import Events, Verdict
from world.record.lines import Line
from world.record.recorder import Header, Recorder, open_events
from world.scenario.scenario import load

PAPER = load("paper")
HEADER = Header(
    run="20261120T120000Z-0a1b",
    seed=1,
    speed=1.0,
    started_at="2026-11-20T12:00:00+00:00",
    scenario=msgspec.json.decode(msgspec.json.encode(PAPER)),
    scenario_hash=PAPER.fingerprint(),
    versions={"clew": "0.1.0"},
)
AT_REST: tuple[tuple[str, Record], ...] = (
    *(
        ("world", PoseSampled(robot=robot, x_m=pose.x_m, y_m=pose.y_m, heading_rad=pose.heading_rad))
        for robot, pose in enumerate(PAPER.fleet.poses(), start=1)
    ),
    ("world", RunEnded(reason="interrupted")),
)
"""A run in which no robot ever moved: every promise was kept."""
GOOD = Verdict(
    ok=True,
    exit_code=0,
    reason="every living robot has arrived",
    scenario="paper",
    seed=1,
    robots=5,
    law="printed",
    speed=None,
    started_at="2026-11-20T12:00:00+00:00",
    no_route=False,
    goal_reached=True,
    robots_arrived=5,
    clearance_m_min=0.064,
    clearance_m_required=0.0,
    moving_clearance_m_min=None,
    separation_m_min=0.1,
    separation_m_required=0.04,
    violations=0,
    violations_by_invariant=dict.fromkeys(INVARIANTS, 0),
    switching_steps=10,
    planning_events=40,
    scans=41,
    path_m=7.0,
    table_rms_m=0.0254,
    sim_s=31.0,
    wall_s=2.0,
    cpu_s=1.0,
    messages=Messages(sent=100, received=100, injected={}, refused=0, unaccounted=0, left_out=()),
    events=Events(recorded=500, missing=0),
    deaths=(),
)
"""The verdict on a successful run of paper.toml."""


def numbered(records: Sequence[tuple[str, Record]]) -> list[Line]:
    """Entries with their numbers per source, one per second."""
    counts = dict.fromkeys((source for source, _ in records), 0)
    lines = []
    for second, (source, record) in enumerate(records):
        counts[source] += 1
        lines.append((source, Entry(n=counts[source], t_s=float(second), hlc="0/0", record=record)))
    return lines


def recorded(folder: Path, lines: list[Line]) -> Path:
    """A run's folder that holds these entries."""
    with open_events(folder) as file:
        recorder = Recorder(file, HEADER)
        for source, entry in lines:
            recorder.take(source, [entry])
    return folder
