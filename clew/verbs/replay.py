"""`clew replay`: feeds recorded inputs to new cores and compares their decisions."""

from pathlib import Path

import click
import msgspec

from clew.verbs.options import AS_JSON, ROBOTS
from protocol.exit_codes import ExitCode


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--robot", type=ROBOTS, help="Replay only this robot.")
@AS_JSON
@click.pass_context
def replay(ctx: click.Context, run: Path, *, robot: int | None, as_json: bool) -> None:
    """Feed each robot's recorded inputs to a new core, and compare its decisions with the recorded ones.

    RUN is the folder of a run, live or rehearsed. The replay of a robot stops at the first difference. Exits
    with 1 when a decision differs, or when a journal is damaged or missing. The journal of a process that was
    killed may end anywhere.
    """
    from clew.log.replay import replay as replay_run
    from clew.log.replay import sentences

    replayed = replay_run(run, robot)
    if as_json:
        click.echo(msgspec.json.encode(replayed).decode())
    else:
        for sentence in sentences(replayed):
            click.echo(sentence)
    ctx.exit(ExitCode.OK if replayed.ok else ExitCode.FAILED)
