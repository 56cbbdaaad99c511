"""`clew chaos`: live fleets, one after the other, each under faults that its seed draws."""

import os
import shutil
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import click
import msgspec
from rich.console import Console
from rich.table import Table

from clew.campaign.campaign import write_drawn
from clew.campaign.chaos import Chaos, ChaosRun, judge_run, replay_line, sum_up
from clew.campaign.episode import drawn_plan_path
from clew.fleet.folder import RUNS, make_folder
from clew.fleet.live import run_fleet
from clew.swarm.swarm import draw
from clew.verbs.options import AS_JSON, SEED
from clew.verbs.say import say, warn
from protocol.asked import AskedToEnd, terminable
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.files.writing import make_folder as make_private
from protocol.files.writing import write_whole
from protocol.run_settings import SPEED_MAX

CHAOS_FILE = "chaos.json"
PIPE_COLUMNS = 140  # the table's width where stdout is no terminal
LATE = 2.0  # so many times slower than asked for a busy machine may be,
START_S = 60.0  # and so much longer it may take to begin and to end


@click.command()
@click.option("--runs", type=click.IntRange(1, 10_000), default=50, show_default=True, help="How many.")
@click.option(
    "--speed",
    type=click.FloatRange(0.0, SPEED_MAX, min_open=True),
    default=2.0,
    show_default=True,
    help="Times real time.",
)
@click.option("--seed", type=SEED, default=1, show_default=True, help="Of the first; the next has one more.")
@click.option("--out", type=click.Path(path_type=Path), help="New or empty: for worlds, plans and runs.")
@AS_JSON
@click.pass_context
@terminable()
def chaos(ctx: click.Context, *, runs: int, speed: float, seed: int, out: Path | None, as_json: bool) -> None:
    """Run live fleets through what the swarm of a campaign draws: loss, cuts, kills, freezes, restarts.

    Folders of runs are kept that had trouble or did not arrive.

    Exit code: 0 no trouble, 1 trouble (a violation, books that do not balance, a log that is not whole,
    a launcher that refuses, something left behind), 2 it cannot be done as asked,
    130, 143 or 129 ended by Ctrl-C, SIGTERM or SIGHUP, and so was its fleet.
    """
    folder = out or RUNS / f"chaos-{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    make_folder(folder)  # so what stands in it from now on, and may be removed, is of this call
    done: list[ChaosRun] = []
    asked: ExitCode | None = None
    try:
        for each in range(seed, seed + runs):
            done.append(_play(each, f"{speed:g}", folder))
            warn(_sentence(done[-1], len(done), runs))
    except AskedToEnd as signal:
        asked = signal.exit_code
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror or error}") from error
    result = sum_up(done, asked=runs, speed=f"{speed:g}", interrupted=asked is not None)
    said = msgspec.json.format(msgspec.json.encode(result))
    write_whole(folder / CHAOS_FILE, said + b"\n")
    if as_json:
        click.echo(said.decode())
    else:
        _print(result, folder)
    ctx.exit(asked or (ExitCode.OK if result.ok else ExitCode.FAILED))


def _play(seed: int, speed: str, folder: Path) -> ChaosRun:
    """One fleet; its run's folder is kept if anybody may want to see it."""
    swarm, path, run = draw(seed), folder / "drawn" / f"{seed}.toml", folder / f"run-{seed}"
    write_drawn(seed, path)
    plan = drawn_plan_path(str(path))
    arguments = [str(path), "--faults", plan, "--seed", str(seed), "--speed", speed, "--out", str(run)]
    wall_s_max = START_S + LATE * swarm.scenario.time.time_s_max / float(speed)
    ended = run_fleet(arguments, wall_s_max=wall_s_max)
    load, _, _ = os.getloadavg()
    judged = judge_run(swarm, run, ended, replay=replay_line(path, seed, speed), load=load)
    if judged.troubles or not judged.arrived:
        make_private(run)
        write_whole(run / "stderr.txt", "".join(f"{line}\n" for line in ended.said).encode())
    else:
        shutil.rmtree(run)
    return judged


def _sentence(run: ChaosRun, number: int, runs: int) -> str:
    outcome = "; ".join(run.troubles) or ("arrived" if run.arrived else f"did not arrive: {run.reason}")
    return f"chaos: {number} of {runs}, seed {run.seed}: {outcome} ({run.wall_s:.0f} s)"


def _print(result: Chaos, folder: Path) -> None:
    console = Console() if sys.stdout.isatty() else Console(width=PIPE_COLUMNS)
    console.print(_table(result.each))
    for run in result.each:
        for trouble in run.troubles:
            say(f"TROUBLE, seed {run.seed}: {trouble}")
        if not run.arrived:
            say(f"did not arrive, seed {run.seed} ({run.mode}): {run.reason}")
        if run.troubles or not run.arrived:
            say(f"    {run.replay}")
    word = "INTERRUPTED" if result.interrupted else "OK" if result.ok else "FAILED"
    process_faults = ", ".join(f"{fault} {count}" for fault, count in result.process_faults.items())
    click.echo(
        f"{word}: {result.runs} of {result.runs_asked} runs, {result.violations} violations, "
        f"{result.unbalanced} unbalanced, {result.leftovers} left behind, "
        f"{result.not_arrived} did not arrive; {result.messages_sent} messages, "
        f"{result.messages_unaccounted} unaccounted for; process faults: {process_faults or 'none'}. "
        f"Chaos: {folder}"
    )


def _table(runs: Sequence[ChaosRun]) -> Table:
    counts = ("arrived", "broken", "sent", "injected", "refused", "lost")
    drawn = Table("seed", "faults", *counts, "log", "left", "sim, s", "wall, s", "load")
    for column in (drawn.columns[0], *drawn.columns[2:]):
        column.justify = "right"
    for run in runs:
        books = run.messages
        told = ("-",) * 4
        if books is not None:
            injected = sum(books.injected.values())
            told = (str(books.sent), str(injected), str(books.refused), str(books.unaccounted))
        drawn.add_row(
            str(run.seed),
            f"{run.ground}: {', '.join(run.classes)}",
            f"{run.robots_arrived}/{run.robots}",
            str(run.violations),
            *told,
            "ok" if run.log_ok else "FLAWED",
            str(len(run.leftovers)),
            f"{run.sim_s:.1f}",
            f"{run.wall_s:.1f}",
            f"{run.load:.1f}",
        )
    return drawn
