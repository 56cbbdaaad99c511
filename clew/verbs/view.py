"""`clew view`: serves the page of a run to a browser, live while the run goes on."""

from pathlib import Path

import click

from clew.fleet.folder import LATEST
from clew.verbs.options import PATH
from protocol.errors import UsageError

RUNS_MAX = 2  # fit side by side
STDIN = 0


@click.command()
@click.argument("runs", metavar="RUN...", nargs=-1, type=PATH)
@click.option(
    "--live", is_flag=True, help="Wait for runs that have not started yet; the default RUN is runs/latest."
)
@click.option(
    "--port",
    type=click.IntRange(0, 65_535),
    default=0,
    help="Port on the loopback address; 0: any free port.",
)
@click.option("--open", "opens", is_flag=True, help="Open the page in a browser.")
@click.option("--lifeline", is_flag=True, hidden=True, help="End when stdin does: launch/fleet.sh says so.")
@click.pass_context
def view(
    ctx: click.Context, runs: tuple[Path, ...], *, live: bool, port: int, opens: bool, lifeline: bool
) -> None:
    """Serve the page of a run, or of two runs side by side, to browsers on this machine.

    RUN is the folder of a run, or its events.jsonl. The verb prints the address and serves until Ctrl-C.
    """
    import asyncio
    import webbrowser

    from clew.page.serve.channel import Channel
    from clew.page.serve.pages import site
    from clew.page.serve.server import Server
    from clew.page.serve.watch import Watch

    places = _places(runs, live=live)

    def ready(address: str) -> None:
        click.echo(address)
        if opens and not webbrowser.open(address):
            click.echo("view: no browser was found", err=True)

    channels = [Channel(Watch(place)) for place in places]
    server = Server(site(len(channels)), channels)
    ctx.exit(asyncio.run(server.serve(port, ready, STDIN if lifeline else None)))


def _places(runs: tuple[Path, ...], *, live: bool) -> tuple[Path, ...]:
    """Where the runs are, or will be.

    Raises:
        UsageError: no run or more than two are named, one is not there without --live, or one is no log.
    """
    from clew.log.log import Log, fleets_in
    from world.record.recorder import EVENTS_FILE

    places = runs or ((LATEST,) if live else ())
    if not 1 <= len(places) <= RUNS_MAX:
        raise UsageError(f"view: name one run, or two to see side by side, got {len(places)}")
    for place in places:
        if not _is_there(place):
            if fleets_in(place):
                Log(place)  # says so
            if not live:
                raise UsageError(f"no run in {place}: {EVENTS_FILE} is not there; --live waits for it")
            click.echo(f"view: waiting for a run in {place}", err=True)
        elif not live or place.is_file():
            Log(place)
    return places


def _is_there(place: Path) -> bool:
    from world.record.recorder import EVENTS_FILE

    return (place / EVENTS_FILE).is_file() or place.is_file()
