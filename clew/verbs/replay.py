"""`clew replay`: feeds recorded inputs to new cores, compares their decisions, and shows their states."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.options import AS_JSON, FINITE, ROBOT, RUN_FOLDER
from clew.verbs.say import say, warn
from protocol.exit_codes import ExitCode

if TYPE_CHECKING:
    from clew.log.journals.stop import Stop


@click.command()
@click.argument("run", type=RUN_FOLDER)
@click.option("--robot", type=ROBOT, help="Replay only this robot.")
@click.option("--until", "until_s", type=FINITE, help="Stop at this time, and show the state [simulated s].")
@click.option(
    "--break",
    "text",
    metavar="EXPR",
    help="Stop at the first event after which this is true of the state; docs/replay.md lists its names.",
)
@AS_JSON
@click.pass_context
def replay(
    ctx: click.Context,
    run: Path,
    *,
    robot: int | None,
    until_s: float | None,
    text: str | None,
    as_json: bool,
) -> None:
    """Feed each robot's recorded inputs to a new core, and compare its decisions with the recorded ones.

    RUN is the folder of a run, or its events.jsonl. The replay of a robot stops at the first difference.
    Exits with 1 when a decision differs, or when a journal is damaged or missing. The journal of a process
    that was killed may end anywhere.

    With --until or --break, it shows the state of the core there instead. Exits with 1 when the expression
    never becomes true, or when a decision up to there differs from the recorded one.
    """
    from clew.log.journals.stop import condition, first, gaps, moments
    from clew.log.replay import replay as replay_run
    from clew.log.replay import sentences

    if text is not None or until_s is not None:
        for gap in gaps(run, robot):
            warn(f"not complete: {gap}")
    if text is not None:
        found = first(run, condition(text), until_s=until_s, robot=robot)
        if found is None:
            warn(f"after no event is this true: {text}")
        ctx.exit(_show([] if found is None else [found], as_json=as_json))
    if until_s is not None:
        ctx.exit(_show(moments(run, until_s=until_s, robot=robot), as_json=as_json))
    replayed = replay_run(run, robot)
    if as_json:
        click.echo(msgspec.json.encode(replayed).decode())
    else:
        for sentence in sentences(replayed):
            click.echo(sentence)
    ctx.exit(ExitCode.OK if replayed.ok else ExitCode.FAILED)


def _show(stops: "list[Stop]", *, as_json: bool) -> ExitCode:
    """Show cores; returns the exit code."""
    from clew.log.replay import shown

    for stop in stops:
        if as_json:
            about = {"incarnation": stop.head.incarnation, "decided": shown(stop.decided)}
            told = {**msgspec.to_builtins(stop.state), **about, "differs": stop.differs}
            say(msgspec.json.encode(told).decode())
        else:
            _tell(stop)
        if stop.differs is not None:
            warn(f"robot {stop.head.robot}: from input {stop.differs} on, it decides otherwise than recorded")
    is_same = bool(stops) and all(stop.differs is None for stop in stops)
    return ExitCode.OK if is_same else ExitCode.FAILED


def _tell(stop: "Stop") -> None:
    from clew.log.journals.contents import does
    from clew.log.journals.state import headline, lines_of

    say(headline(stop.state, stop.head.incarnation))
    for line in lines_of(stop.state):
        say(line)
    if stop.decided.failed is not None:
        say(f"  failed  {stop.decided.failed}")
    for _, command in stop.decided.commands:
        say(f"  then    it {does(stop.head.robot, command)}")
