"""The command line of each part of a fleet, and the destination of its output.

Rule 1: the robots of a large fleet give way to world and router. Else hundreds of processes that all have
        something to do at once leave a hundredth of a core to the world, and its ticks are late.
"""

import math
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from pathlib import Path

from clew.fleet.prepare import Prepared
from clew.fleet.supervision.events import HOST, TABLE, VIEWER, WORLD, router_name
from protocol.keys import WORLD as WORLD_SESSION
from protocol.network.session import ROUTERS_MAX
from world.scenario.scenario import Scenario

SAID_FILE = "said"
"""In the private folder: the output of the parts while the user sees a table or nothing."""


ROBOTS_WEIGH = 4.0  # times one process: the world needs some 5 ms of its core at once
NICE_STEP = 1.25  # by so much less weighs a process for each step: sched(7)
NICE_MAX = 19


class Stdout(Enum):
    """The destination of a part's stdout. Its stderr goes to ours or to the file `said`."""

    STDERR = auto()
    READY = auto()
    """Read by us: the first line means that the part is ready."""
    TERMINAL = auto()
    """The user's terminal, like its stderr."""


@dataclass(frozen=True, slots=True)
class Part:
    """How to start a part."""

    arguments: Callable[[Prepared], list[str]]
    """The arguments of Python."""
    stdout: Stdout = Stdout.STDERR
    nice: Callable[[Prepared], int] = lambda _: 0
    """By how much it gives way to others."""


def _router(number: int) -> Part:
    def arguments(run: Prepared) -> list[str]:
        return ["-m", "protocol", "--sessions", str(run.private), "--number", str(number)]

    return Part(arguments, Stdout.READY)


def _world(run: Prepared) -> list[str]:
    sessions = [private / f"{WORLD_SESSION}.json" for _, private, _ in _crews(run)]
    return ["-m", "world", str(run.folder), *(said for path in sessions for said in ("--session", str(path)))]


def _host(run: Prepared) -> list[str]:
    robots = [
        said
        for folder, private, robots in _crews(run)
        for said in ("--robots", f"1-{robots}", "--run", str(folder), "--sessions", str(private))
    ]
    return ["-m", "agents", *robots, "--host"]


def nice_of(robots: int, cores: int) -> int:
    """Rule 1: by how much robots give way: those of one core weigh at most `ROBOTS_WEIGH` together."""
    return min(max(math.ceil(math.log(robots / cores / ROBOTS_WEIGH, NICE_STEP)), 0), NICE_MAX)


def _crews(run: Prepared) -> list[tuple[Path, Path, int]]:
    """The folders of each fleet, the run's and the private one, and how many robots it has."""
    if isinstance(run.scenario, Scenario):
        return [(run.folder, run.private, run.robots)]
    return [(run.folder / each.name, run.private / each.name, each.robots) for each in run.scenario.fleets]


def _viewer(run: Prepared) -> list[str]:
    return ["-m", "clew.cli", "view", "--live", str(run.folder)]


def _table(run: Prepared) -> list[str]:
    return ["-m", "clew.fleet.table", str(run.folder), "--said", str(run.private / SAID_FILE)]


PARTS: Mapping[str, Part] = {
    **{router_name(number): _router(number) for number in range(1, ROUTERS_MAX + 1)},
    WORLD: Part(_world),
    HOST: Part(_host, nice=lambda run: nice_of(run.robots, len(os.sched_getaffinity(0)))),
    VIEWER: Part(_viewer, Stdout.READY, nice=lambda _: 10),
    TABLE: Part(_table, Stdout.TERMINAL),
}


def command_of(name: str, run: Prepared, *, resume: bool = False) -> list[str]:
    """The command line that starts a part; all parts except the table get the option for the lifeline."""
    part = PARTS[name]
    lifeline = [] if name == TABLE else ["--lifeline"]
    again = ["--resume"] if resume else []
    gently = ["nice", "-n", str(nice)] if (nice := part.nice(run)) > 0 else []
    return [*gently, sys.executable, *part.arguments(run), *lifeline, *again]
