"""Checks the whole request for a live run before anything starts.

Rule 1: a request that cannot work is refused and leaves nothing behind.
Rule 2: the run's folder is made last.
"""

import asyncio
import os
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import Enum
from pathlib import Path

from clew.fleet.folder import LATEST, RUNS, drop_folder, folder_name, make_folder
from clew.fleet.request import MIB_BYTES, Request
from protocol import laws
from protocol.errors import UsageError
from protocol.faults.fit import check_fits
from protocol.faults.plan import NO_FAULTS
from protocol.faults.plan import load as load_plan
from protocol.keys import WORLD
from protocol.network.interlink import PROTOCOL
from protocol.network.session import INPUTS, Session, read_session, unix_socket_endpoint, write_sessions
from protocol.run_settings import Settings
from world.record.run_files import prepare_folder
from world.scenario.scenario import Scenario, load

FLEET = "clew"  # every key also has the run's name, which tells two fleets apart


def run_name(now: datetime, token: str) -> str:
    """The run's name in keys and in the timeline. It is unique and sorts by time."""
    return f"{now:%Y%m%dT%H%M%SZ}-{token}"


class Shows(Enum):
    """What the user sees during a run."""

    TABLE = "table"
    LINES = "lines"
    NOTHING = "nothing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared:
    """A run that may start."""

    private: Path
    """The private folder with its sessions and sockets."""
    folder: Path
    """The run's folder, by the path that the user gave."""
    made: tuple[Path, ...]
    """The folders that were created for it, deepest first."""
    latest: Path | None
    """The link to the newest run."""
    scenario: Scenario
    settings: Settings
    started_at: str
    """UTC."""
    own_routers: int
    """0: the user runs the router."""
    as_json: bool
    view: bool
    shows: Shows

    @property
    def robots(self) -> int:
        """How many robots the fleet has."""
        return self.scenario.fleet.robots


def shows(request: Request, environment: Mapping[str, str], *, terminal: bool) -> Shows:
    """What the user sees during this run."""
    if request.quiet:
        return Shows.NOTHING
    # A terminal without a type cannot move its cursor, and a CI log is read later.
    plain = environment.get("TERM", "dumb") == "dumb" or environment.get("CI") or request.as_json
    return Shows.TABLE if terminal and not plain else Shows.LINES


def probe(session: Session) -> None:
    """Check that a router admits a session, before six processes report that it does not.

    Raises:
        UsageError: it does not.
    """
    from protocol.network.zenoh_transport import open_transport  # noqa: PLC0415 - few runs need Zenoh here

    async def look() -> None:
        with open_transport(session, hear=(), answer=(), alive=None, watch=()):
            pass

    asyncio.run(look())


def free_endpoint() -> str:
    """A loopback port that is free now, for the connection between two routers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"{PROTOCOL}/127.0.0.1:{server.getsockname()[1]}"


def _endpoints(request: Request, private: Path) -> list[str]:
    """The endpoints of the routers."""
    asked = request.connect or request.listen
    if asked is not None:
        return [asked]
    return [unix_socket_endpoint(private, number) for number in range(1, request.routers + 1)]


def prepare(request: Request, private: Path, *, terminal: bool) -> Prepared:
    """Write the sessions and make the run's folder.

    Args:
        request: the user's request.
        private: the folder for sessions and sockets, which exists.
        terminal: whether stdout and stderr are terminals.

    Raises:
        UsageError: the run cannot start as requested.
        SessionLostError: the user's router was lost during the check.
    """
    scenario = load(
        request.scenario,
        robots=request.robots,
        law=request.law,
        deployment=request.deployment,
        time_s_max=request.time_s_max,
        seed=request.seed,
    )
    robots = scenario.mission().robots
    laws.find(scenario.law.law)  # before anything starts: each robot would refuse the mission
    plan = NO_FAULTS if request.faults is None else load_plan(request.faults)
    check_fits(plan, robots=robots)
    now, token = datetime.now(UTC), secrets.token_hex(2)
    folder = request.out or RUNS / folder_name(now, scenario.name, token)
    write_sessions(
        private,
        fleet=FLEET,
        run=run_name(now, token),
        robots=robots,
        endpoints=_endpoints(request, private),
        interlink=free_endpoint() if request.routers > 1 else None,
        passwords=request.connect is None,
        inputs=folder.absolute() / INPUTS if request.keep > 0.0 else None,
        inputs_bytes_max=max(1, round(request.keep * MIB_BYTES)),
    )
    if request.connect is not None:
        probe(read_session(private / f"{WORLD}.json"))
    settings = Settings(seed=request.seed, speed=request.speed, held=request.held)
    made = make_folder(folder.absolute())
    try:
        prepare_folder(folder, scenario, plan, settings)
    except UsageError:
        drop_folder(folder, made, latest=None)
        raise
    return Prepared(
        private=private,
        folder=folder,
        made=tuple(made),
        latest=None if request.out else LATEST,
        scenario=scenario,
        settings=settings,
        started_at=now.isoformat(timespec="seconds"),
        own_routers=request.routers if request.connect is None else 0,
        as_json=request.as_json,
        view=request.view,
        shows=shows(request, os.environ, terminal=terminal),
    )
