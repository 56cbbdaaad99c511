"""Logs of a million entries: `python -m tests.support.logs.long_logs FOLDER [ENTRIES]` makes one."""

import sys
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

import msgspec

from protocol.timeline import (
    AuthorityGranted,
    Entry,
    LinkHeard,
    LinkSilent,
    PoseSampled,
    Record,
    RobotHeld,
    RobotReleased,
    RobotStarted,
    RunEnded,
    ScanServed,
)
from tests.support.logs.logs import HEADER, PAPER
from world.record.recorder import EVENTS_FILE, line

MILLION = 1_000_000
PERIOD_S = 0.1
POSES_OF_TEN = 8
SCAN_EVERY = 500  # a scan is as long as twenty other entries: scans make up a sixth of the file


def make(folder: Path, entries: int = MILLION) -> Path:
    """A run's folder with a log of this many entries: the robots stand and exchange messages."""
    folder.mkdir(parents=True)
    counts = dict.fromkeys(("world", *(f"r{robot}" for robot in range(1, PAPER.fleet.robots + 1))), 0)
    with (folder / EVENTS_FILE).open("wb") as file:
        file.write(msgspec.json.encode(HEADER) + b"\n")
        for place, (source, record) in enumerate(_records(entries)):
            counts[source] += 1
            t_s = round(place / (10 * PAPER.fleet.robots)) * PERIOD_S
            hlc = f"{int(t_s * 2**32)}/{source}"
            file.write(line(source, Entry(n=counts[source], t_s=t_s, hlc=hlc, record=record)))
    return folder


def _records(entries: int) -> Iterator[tuple[str, Record]]:
    robots = range(1, PAPER.fleet.robots + 1)
    yield from ((f"r{robot}", RobotStarted(pid=robot)) for robot in robots)
    poses = PAPER.fleet.poses()
    talk: list[Record] = [
        AuthorityGranted(to=2, epoch=1, authority_m=0.123456789),
        LinkSilent(neighbour=2, silent_s=0.4),
        LinkHeard(neighbour=2),
        RobotHeld(behind_m=0.25),
        RobotReleased(),
    ]
    turns = zip(cycle(robots), cycle(talk), strict=True)
    for place in range(entries - len(robots) - 1):
        robot = place % len(robots) + 1
        at = poses[robot - 1]
        if place % SCAN_EVERY == 0:
            where = {"x_m": at.x_m, "y_m": at.y_m, "heading_rad": at.heading_rad}
            ranges_m = tuple(round(0.5 + ray / 300, 3) for ray in range(360))
            yield "world", ScanServed(robot=robot, **where, revolutions=1, hits=360, ranges_m=ranges_m)
        elif place % 10 < POSES_OF_TEN:
            where = {"x_m": at.x_m, "y_m": at.y_m, "heading_rad": at.heading_rad}
            yield "world", PoseSampled(robot=robot, **where, clearance_m=0.123456, separation_m=0.234567)
        else:
            speaker, record = next(turns)
            yield f"r{speaker}", record
    yield "world", RunEnded(reason="interrupted")


if __name__ == "__main__":
    make(Path(sys.argv[1]), *map(int, sys.argv[2:]))
