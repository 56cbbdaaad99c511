"""`clew replay`: gives recorded inputs to fresh cores and compares what they decide."""

from pathlib import Path

import click
import msgspec

from clew.log.replay import replay as replay_run
from clew.log.replay import sentences
from clew.verbs.options import AS_JSON, ROBOTS
from protocol.exit_codes import ExitCode


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--robot", type=ROBOTS, help="Only this robot.")
@AS_JSON
@click.pass_context
def replay(ctx: click.Context, run: Path, *, robot: int | None, as_json: bool) -> None:
    """Give all that each robot heard to a fresh core, and compare each decision with the one recorded.

    RUN is a run's folder, live or rehearsed.

    Exit code: 0 all the same, 1 a difference, at the first of which it stops, or not all could be compared: a
    journal is damaged, or a robot that took part has none; 2 there is nothing to replay. A journal whose
    process was killed may end anywhere.
    """
    replayed = replay_run(run, robot)
    if as_json:
        click.echo(msgspec.json.encode(replayed).decode())
    else:
        for sentence in sentences(replayed):
            click.echo(sentence)
    ctx.exit(ExitCode.OK if replayed.ok else ExitCode.FAILED)
