"""Checks the whole request for a live run before anything starts.

Rule 1: a request that cannot work is refused and leaves nothing behind.
Rule 2: the run's folder is made last.
"""

import asyncio
import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import Enum
from pathlib import Path

from msgspec.structs import replace

from clew.fleet.folder import LATEST, RUNS, drop_folder, folder_name, make_folder
from clew.fleet.request import MIB_BYTES, Request
from clew.swarm.plans import plan_for
from protocol import laws
from protocol.errors import UsageError
from protocol.faults.fit import check_fits
from protocol.faults.plan import Plan
from protocol.faults.process_commands import PIPE
from protocol.faults.rules import ROUTER, ProcessRule
from protocol.files.writing import make_folder as make_private
from protocol.keys import WORLD
from protocol.network.session import (
    INPUTS,
    Crew,
    Session,
    read_session,
    unix_socket_endpoint,
    write_all_sessions,
)
from protocol.run_settings import Settings
from world.record.run_files import prepare_folder, prepare_together
from world.scenario.fleets import SharedGround, load_any, seed_of
from world.scenario.scenario import Scenario

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
    scenario: Scenario | SharedGround
    settings: Settings
    started_at: str
    """UTC."""
    own_routers: int
    """0: the user runs the router."""
    as_json: bool
    view: bool
    shows: Shows

    @property
    def fleets(self) -> tuple[str, ...]:
        """The names of the fleets, where there are several; each has a folder in both of the run's."""
        if isinstance(self.scenario, Scenario):
            return ()
        return tuple(each.name for each in self.scenario.fleets)

    @property
    def robots(self) -> int:
        """How many robots there are."""
        if isinstance(self.scenario, Scenario):
            return self.scenario.fleet.robots
        return sum(each.robots for each in self.scenario.fleets)


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
    scenario = load_any(
        request.scenario,
        robots=request.robots,
        law=request.law,
        deployment=request.deployment,
        time_s_max=request.time_s_max,
        seed=request.seed,
    )
    several = isinstance(scenario, SharedGround)
    fleets = scenario.scenarios() if isinstance(scenario, SharedGround) else {FLEET: scenario}
    plan = _plan(request, fleets)
    if several:
        _check_several(request, plan)
    now, token = datetime.now(UTC), secrets.token_hex(2)
    folder = request.out or RUNS / folder_name(now, scenario.name, token)
    crews = _crews(request, fleets, private, folder.absolute(), several=several)
    write_all_sessions(
        private,
        crews,
        run=run_name(now, token),
        endpoints=_endpoints(request, private),
        passwords=request.connect is None,
    )
    if request.connect is not None:
        probe(read_session(crews[0].sessions / f"{WORLD}.json"))
    settings = Settings(seed=request.seed, speed=request.speed, held=request.held)
    made = make_folder(folder.absolute())
    try:
        _fill(folder, private, scenario, fleets, plan=plan, settings=settings)
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
        shows=shows(request, os.environ, terminal=terminal and not several),
    )


def _plan(request: Request, fleets: Mapping[str, Scenario]) -> Plan:
    """The fault plan, which fits all fleets; their laws are here, too, else each robot would refuse.

    Raises:
        UsageError: a law is not here, or the plan does not fit.
    """
    robots = min(each.fleet.robots for each in fleets.values())
    plan = plan_for(request.faults, robots=robots, seed=request.seed)
    for each in fleets.values():
        laws.find(each.law.law)
        check_fits(plan, robots=each.mission().robots, source=request.faults)
    return plan


def _crews(
    request: Request, fleets: Mapping[str, Scenario], private: Path, folder: Path, *, several: bool
) -> list[Crew]:
    """What each fleet needs for its sessions. Of several, each has its folders in the run's two."""
    return [
        Crew(
            fleet=name,
            robots=each.fleet.robots,
            sessions=private / name if several else private,
            inputs=(folder / name if several else folder) / INPUTS if request.keep > 0.0 else None,
            inputs_bytes_max=max(1, round(request.keep * MIB_BYTES)),
        )
        for name, each in fleets.items()
    ]


def _fill(
    folder: Path,
    private: Path,
    scenario: Scenario | SharedGround,
    fleets: Mapping[str, Scenario],
    *,
    plan: Plan,
    settings: Settings,
) -> None:
    """Write what a run's new folder holds before its log."""
    if isinstance(scenario, Scenario):
        prepare_folder(folder, scenario, plan, settings)
        return
    prepare_together(folder, scenario, settings)
    for name, each in fleets.items():
        _prepare_fleet(folder / name, private / name, each, plan, settings)


def _check_several(request: Request, plan: Plan) -> None:
    """Refuse what a run with several fleets does not have."""
    for option, asked in (
        ("--view", request.view),
        ("--held", request.held),
    ):
        if asked:
            raise UsageError(f"{option}: is for a scenario with one fleet")
    for row, rule in enumerate(plan.rules):
        if isinstance(rule, ProcessRule) and rule.target in (WORLD, ROUTER):
            raise UsageError(
                f"{request.faults}: $.rule[{row}].target: several fleets share the {rule.target}"
            )


def _prepare_fleet(folder: Path, private: Path, scenario: Scenario, plan: Plan, settings: Settings) -> None:
    """Make the folder of one of several fleets; its faults of shared processes reach the launcher."""
    try:
        make_private(folder)
        (private / PIPE).symlink_to(Path("..") / PIPE)
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror}") from error
    prepare_folder(folder, scenario, plan, replace(settings, seed=seed_of(settings.seed, folder.name)))
