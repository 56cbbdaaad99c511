"""Checks everything that a run is asked for, before anything starts; `launch/fleet.sh` does the rest.

`python -m clew.fleet.prepare PRIVATE OPTION...` writes the run's sessions into the folder PRIVATE, makes the
run's folder last, and prints assignments for bash to evaluate.

Rule 1: what cannot work is one line on stderr and exit code 2, and leaves nothing behind.
Rule 2: every value goes to bash through `shlex.quote`.
"""

import asyncio
import os
import secrets
import shlex
import socket
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from clew.fleet.folder import LATEST, RUNS, folder_name, make_folder
from clew.fleet.request import Request, parse
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.fit import check_fits
from protocol.faults.plan import NO_FAULTS
from protocol.faults.plan import load as load_plan
from protocol.keys import WORLD
from protocol.network.interlink import PROTOCOL
from protocol.network.session import INPUTS, Session, read_session, unix_socket_endpoint, write_sessions
from protocol.network.zenoh_transport import open_transport
from protocol.plain import plain
from protocol.run_settings import Settings
from world.record.run_files import prepare_folder
from world.scenario.scenario import load

FLEET = "clew"  # the run, which stands in every key beside it, is what tells two fleets apart


def run_name(now: datetime, token: str) -> str:
    """The run's name in keys and in the timeline: unique, and sorts by time."""
    return f"{now:%Y%m%dT%H%M%SZ}-{token}"


def assignment(name: str, value: str | Sequence[str]) -> str:
    """A line of bash that gives a variable, or an array, exactly this value."""
    if isinstance(value, str):
        return f"{name}={shlex.quote(value)}"
    return f"{name}=({' '.join(map(shlex.quote, value))})"


def shows(request: Request, environment: Mapping[str, str], *, terminal: bool) -> str:
    """What the user sees of the run while it goes on: a live `table`, `lines`, or `nothing`."""
    if request.quiet:
        return "nothing"
    # A terminal without a name cannot move its cursor, and a CI's log is read later.
    plain = environment.get("TERM", "dumb") == "dumb" or environment.get("CI") or request.as_json
    return "table" if terminal and not plain else "lines"


async def probe(session: Session) -> None:
    """Find out whether a router that the user runs is there, before six processes say that it is not.

    Raises:
        UsageError: it is not.
    """
    with open_transport(session, hear=(), answer=(), alive=None, watch=None):
        pass


def free_endpoint() -> str:
    """A port on loopback that is free at this moment, for what two routers have to say to each other."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"{PROTOCOL}/127.0.0.1:{server.getsockname()[1]}"


def _endpoints(request: Request, private: Path) -> list[str]:
    """Where the routers listen."""
    asked = request.connect or request.listen
    if asked is not None:
        return [asked]
    return [unix_socket_endpoint(private, number) for number in range(1, request.routers + 1)]


def prepare(request: Request, private: Path) -> list[str]:
    """Write the sessions and make the run's folder; returns the assignments for bash.

    Raises:
        UsageError: the run cannot go as it is asked for.
    """
    scenario = load(
        request.scenario,
        robots=request.robots,
        law=request.law,
        deployment=request.deployment,
        seed=request.seed,
    )
    robots = scenario.mission().robots
    plan = NO_FAULTS if request.faults is None else load_plan(request.faults)
    check_fits(plan, robots=robots)
    now, token = datetime.now(UTC), secrets.token_hex(2)
    folder = request.out or RUNS / folder_name(now, request.scenario, token)
    write_sessions(
        private,
        fleet=FLEET,
        run=run_name(now, token),
        robots=robots,
        endpoints=_endpoints(request, private),
        interlink=free_endpoint() if request.routers > 1 else None,
        passwords=request.connect is None,
        inputs=folder.absolute() / INPUTS,
    )
    if request.connect is not None:
        asyncio.run(probe(read_session(private / f"{WORLD}.json")))
    made = make_folder(folder.absolute())
    prepare_folder(folder, scenario, plan, Settings(seed=request.seed, speed=request.speed))
    return [
        assignment("robots", str(robots)),
        assignment("own_routers", str(request.routers if request.connect is None else 0)),
        assignment("as_json", str(int(request.as_json))),
        assignment("view", str(int(request.view))),
        assignment("shows", shows(request, os.environ, terminal=sys.stderr.isatty())),
        assignment("run_folder", str(folder)),
        assignment("made_folders", [str(path) for path in made]),
        assignment("latest", "" if request.out else str(LATEST)),
    ]


def main(arguments: Sequence[str]) -> int:
    """Prepare a run; returns the exit code."""
    if arguments[0] in {"-h", "--help"}:
        parse(arguments)
    try:
        assignments = prepare(parse(arguments[1:]), Path(arguments[0]))
    except UsageError as error:
        sys.stderr.write(f"fleet.sh: {plain(str(error))}\n")
        return ExitCode.USAGE
    except SessionLostError as error:
        sys.stderr.write(f"fleet.sh: {plain(str(error))}\n")
        return ExitCode.FAILED
    sys.stdout.write("\n".join(assignments) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
