"""`clew bench hop`: measures how fast news goes down a strand of real processes."""

import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, runs_option
from protocol.errors import UsageError
from protocol.frames import ROBOTS_MAX
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.hop.chain import Chain

SIZES = (5, 50, 200)
PARTS = ("stack", "asyncio", "callback")


@click.command()
@click.argument("sizes", nargs=-1, type=click.IntRange(2, ROBOTS_MAX))
@runs_option("How many chains of each kind.", default=5)
@click.option(
    "--news", type=click.IntRange(1, 400), default=50, show_default=True, help="Pieces of news for a chain."
)
@AS_JSON
@terminable()
def hop(sizes: tuple[int, ...], *, runs: int, news: int, as_json: bool) -> None:
    """Measure how long news takes from the leader to the last of SIZES robots. Default: 5, 50 and 200.

    Each robot is a process with its own Zenoh session, its shell, its journal and its core. For comparison,
    bare relays in the same run forward the same bytes on the same keys: one in an event loop (asyncio), one
    in Zenoh's thread (callback).
    """
    from clew.bench.hop.chain import figures

    begun = begin(
        "hop",
        "From the leader's put to the last robot's reaction, through real processes: session, event loop, "
        f"codec, shell, journal and core. A repeat is a chain with {news} pieces of news.",
    )
    found, chains = [], []
    for robots in sizes or SIZES:
        with tempfile.TemporaryDirectory(prefix="clew-hop.") as folder, _router(Path(folder), robots):
            repeats = [_repeat(robots, news, Path(folder)) for _ in range(runs)]
        found += figures(repeats)
        chains += [chain for each in repeats for chain in each]
        click.echo(f"{robots} robots: done", err=True)
    begun.say("From the leader's put to the last robot's reaction", found, chains, as_json=as_json)


@contextlib.contextmanager
def _router(folder: Path, robots: int) -> Iterator[None]:
    """The fleet's router, as a process, while the context lasts."""
    from protocol.network.session import unix_socket_endpoint, write_sessions

    write_sessions(folder, fleet="hop", run="1", robots=robots, endpoints=[unix_socket_endpoint(folder)])
    command = [sys.executable, "-m", "protocol", "--sessions", str(folder), "--lifeline"]
    process = subprocess.Popen(  # noqa: S603 - our own program
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with process:
        assert process.stdout is not None
        assert process.stdin is not None
        if not process.stdout.readline().startswith(b"ready"):
            raise UsageError("the router is not ready")
        try:
            yield
        finally:
            process.terminate()


def _repeat(robots: int, news: int, folder: Path) -> "list[Chain]":
    """A chain of every kind, one after the other."""
    import msgspec

    from clew.bench.hop.chain import Chain

    chains = []
    for kind in PARTS:
        command = [sys.executable, "-m", "clew.bench.hop", kind, str(robots), str(news), str(folder)]
        ended = subprocess.run(command, stdout=subprocess.PIPE, check=False)  # noqa: S603 - our own program
        if ended.returncode != 0:
            raise UsageError(f"a chain of {robots} robots has failed: {kind}")
        chains.append(msgspec.json.decode(ended.stdout, type=Chain))
    return chains
