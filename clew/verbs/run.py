"""`clew run`: runs a fleet as real processes. `launch/fleet.sh` calls it.

Rule 1: a request that cannot work ends with one line on stderr and exit code 2, and leaves nothing behind.
Rule 2: a request to end that arrives before the run begins is kept until then. One that arrives after the end
        of the run changes nothing.
"""

from collections.abc import Callable
from typing import Any

import click

from clew.fleet.options import speed_of
from clew.fleet.request import KEEP_MIB_MAX, MIB_BYTES, Request
from clew.verbs.options import (
    DEPLOYMENT,
    FAULTS,
    LAW,
    ONE_SEED,
    OUT,
    QUIET,
    SCENARIO,
    TIME,
    VERSION,
    FiniteRange,
    robots_option,
)
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.network.session import INPUTS_BYTES_MAX, ROUTERS_MAX, check_endpoint
from protocol.process.asked import ignore, listen


class Requests:
    """Collects the requests to end the run, from the first moment on."""

    def __init__(self) -> None:
        self.kept: list[ExitCode] = []
        """The requests that arrived before there was a listener."""
        self._tell: Callable[[ExitCode], None] = self.kept.append

    def note(self, code: ExitCode) -> None:
        """A signal has arrived that asks for this exit code."""
        self._tell(code)

    def hear(self, tell: Callable[[ExitCode], None]) -> None:
        """Pass all requests to this listener, the earlier ones first."""
        self._tell = tell
        for code in self.kept:
            tell(code)


def _speed(_ctx: click.Context, _param: click.Parameter, said: str) -> float | None:
    try:
        return speed_of(said)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error


def _endpoint(_ctx: click.Context, _param: click.Parameter, said: str | None) -> str | None:
    try:
        if said is not None:
            check_endpoint(said)
    except UsageError as error:
        raise click.BadParameter(str(error)) from error
    return said


@click.command()
@SCENARIO
@robots_option("Number of robots, instead of the scenario's.")
@ONE_SEED
@LAW
@DEPLOYMENT
@TIME
@click.option(
    "--speed",
    callback=_speed,
    default="1",
    show_default=True,
    help="Times real time, or max: as fast as the robots answer.",
)
@FAULTS
@OUT
@click.option("--json", "as_json", is_flag=True, help="Print verdict.json and nothing else.")
@QUIET
@click.option("--view", is_flag=True, help="Serve the run's live page on loopback during the run.")
@click.option(
    "--held", is_flag=True, hidden=True, help="Of max: go on only as far as a test asks, as clew.launch does."
)
@click.option(
    "-e",
    "--connect",
    callback=_endpoint,
    metavar="ENDPOINT",
    help="Use the Zenoh router at this endpoint; start none.",
)
@click.option(
    "-l",
    "--listen",
    callback=_endpoint,
    metavar="ENDPOINT",
    help="The endpoint of our router; default: a private socket.",
)
@click.option(
    "--routers",
    type=click.IntRange(1, ROUTERS_MAX),
    default=1,
    show_default=True,
    help="With 2, one takes over when the other dies.",
)
@click.option(
    "--keep",
    type=FiniteRange(0.0, KEEP_MIB_MAX),
    default=INPUTS_BYTES_MAX / MIB_BYTES,
    show_default=True,
    metavar="MIB",
    help="How much of its inputs each robot's process records for replay, from the start; 0: nothing.",
)
@VERSION
@click.pass_context
def run(ctx: click.Context, /, **asked: Any) -> None:  # noqa: ANN401 - the fields of a request
    """Run a fleet as real processes: a router, a world and one for each robot.

    SCENARIO is a name in launch/scenarios/ or its folder fleets/, a TOML file or a scene (JSON); default:
    grove. Progress goes to stderr: a live table on a terminal, otherwise one line for each event. The last
    line on stdout is the verdict and the run's folder.

    Exit code: 0 all promises kept, 1 the run failed or broke a promise, 2 cannot run as asked, 130 Ctrl-C,
    143 SIGTERM, 129 SIGHUP, 128+n signal n killed the world too often.
    """
    request, requests = request_of(asked), Requests()
    listen(requests.note)
    try:
        # It imports numpy and scipy, which neither help nor a refusal needs.
        from clew.fleet.shell import run_fleet

        code = run_fleet(request, requests.hear)
    except SessionLostError as error:
        raise click.ClickException(str(error)) from error  # exit code 1
    finally:
        ignore()
    ctx.exit(code)


def request_of(asked: dict[str, Any]) -> Request:
    """The request with these fields.

    Raises:
        UsageError: some of them exclude each other.
    """
    request = Request(**asked)
    if request.connect and request.listen:
        raise UsageError("--connect: not allowed with --listen")
    if request.routers > 1 and (request.connect or request.listen):
        raise UsageError("--routers: two have private sockets, not allowed with --connect or --listen")
    return request
