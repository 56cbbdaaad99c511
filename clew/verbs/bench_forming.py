"""`clew bench forming`: measures how much work it takes until a fleet drives as one strand."""

import time
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON
from protocol.exit_codes import ExitCode
from protocol.frames import ROBOTS_MAX

if TYPE_CHECKING:
    from clew.bench.forming import Forming


@click.command(name="forming")
@click.argument("fleets", nargs=-1, type=click.IntRange(1, ROBOTS_MAX))
@AS_JSON
@click.pass_context
def forming_(ctx: click.Context, fleets: tuple[int, ...], *, as_json: bool) -> None:
    """Rehearse queues of FLEETS robots until they have formed a strand. Default: 5, 50, 200 and 1000.

    Prints the CPU seconds, and how many messages each robot has sent until then. Exits with 1 when a queue
    did not form, or one of up to 200 robots took more than 10 CPU seconds.
    """
    from clew.bench.forming import FLEETS, figures, forming
    from clew.bench.result import all_met

    begun = begin("forming", "Queues of robots on open ground, rehearsed until they have formed a strand.")
    rows: list[Forming] = []
    for robots in fleets or FLEETS:
        rows.append(forming(robots, cpu=time.process_time))
        click.echo(f"{robots} robots: {rows[-1].cpu_s:.2f} CPU s", err=True)
    found = figures(rows)
    begun.say("Queues until they have formed", found, rows, as_json=as_json)
    ctx.exit(ExitCode.OK if all_met(found) else ExitCode.FAILED)
