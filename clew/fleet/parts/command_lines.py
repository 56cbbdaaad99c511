"""The command line of each part of a fleet, and the destination of its output."""

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
    nice: bool = False
    """It runs at low priority."""


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
    HOST: Part(_host),
    VIEWER: Part(_viewer, Stdout.READY, nice=True),
    TABLE: Part(_table, Stdout.TERMINAL),
}


def command_of(name: str, run: Prepared, *, resume: bool = False) -> list[str]:
    """The command line that starts a part; all parts except the table get the option for the lifeline."""
    part = PARTS[name]
    lifeline = [] if name == TABLE else ["--lifeline"]
    again = ["--resume"] if resume else []
    return [*(["nice"] if part.nice else []), sys.executable, *part.arguments(run), *lifeline, *again]
