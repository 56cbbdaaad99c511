"""Which command line starts each part of a fleet, and where what it says goes."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto

from clew.fleet.prepare import Prepared
from clew.fleet.supervision.events import HOST, TABLE, VIEWER, WORLD, router_name
from protocol.keys import WORLD as WORLD_SESSION
from protocol.network.session import ROUTERS_MAX

SAID_FILE = "said"
"""In the private folder: what the parts say while the user sees a table, or nothing."""


class Stdout(Enum):
    """Where a part's stdout goes. Its stderr goes where ours does, or into the file `said`."""

    STDERR = auto()
    READY = auto()
    """To us: its first line means that it is ready."""
    TERMINAL = auto()
    """To the user's terminal, with its stderr."""


@dataclass(frozen=True, slots=True)
class Part:
    """How a part is started."""

    arguments: Callable[[Prepared], list[str]]
    """Of Python."""
    stdout: Stdout = Stdout.STDERR
    nice: bool = False
    """It takes what time the fleet leaves."""


def _router(number: int) -> Part:
    def arguments(run: Prepared) -> list[str]:
        return ["-m", "protocol", "--sessions", str(run.private), "--number", str(number)]

    return Part(arguments, Stdout.READY)


def _world(run: Prepared) -> list[str]:
    return ["-m", "world", str(run.folder), "--session", str(run.private / f"{WORLD_SESSION}.json")]


def _host(run: Prepared) -> list[str]:
    robots = ["--robots", f"1-{run.robots}", "--host"]
    return ["-m", "agents", *robots, "--run", str(run.folder), "--sessions", str(run.private)]


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
    """The command line that starts a part; all but the table are told that stdin is their lifeline."""
    part = PARTS[name]
    lifeline = [] if name == TABLE else ["--lifeline"]
    again = ["--resume"] if resume else []
    return [*(["nice"] if part.nice else []), sys.executable, *part.arguments(run), *lifeline, *again]
