"""`clew chaos`: runs live fleets, one after the other, each with faults that its seed draws."""

import os
import shutil
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.fleet.folder import RUNS, make_folder
from clew.fleet.live import run_fleet
from clew.verbs.options import AS_JSON, PATH, SEED, SPEED, runs_option, wall_s_max
from clew.verbs.say import console, numbers_table, say, to_copy, warn
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.files.writing import make_folder as make_private
from protocol.files.writing import write_whole
from protocol.process.asked import AskedToEnd, terminable

if TYPE_CHECKING:
    from rich.table import Table

    from clew.campaign.chaos import Chaos, ChaosRun

CHAOS_FILE = "chaos.json"


@click.command()
@runs_option("Number of fleets.", default=50)
@SPEED
@click.option(
    "--seed",
    type=SEED,
    default=1,
    show_default=True,
    help="Seed of the first fleet; each next one is one higher.",
)
@click.option("--out", type=PATH, help="New or empty folder for worlds, plans and runs.")
@AS_JSON
@click.pass_context
@terminable()
def chaos(ctx: click.Context, *, runs: int, speed: float, seed: int, out: Path | None, as_json: bool) -> None:
    """Run live fleets under the faults that a swarm campaign draws.

    Faults are lost messages, cut links, kills, freezes and restarts. The folders of runs that had trouble, or
    did not arrive or recover, are kept. Exits with 1 when a run had trouble: a violation, books that do not
    balance, a log with gaps, a launcher that refuses, or something left behind.
    """
    from clew.campaign.chaos import sum_up

    folder = out or RUNS / f"chaos-{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    make_folder(folder)  # empty now, so everything in it later is from this call and may be removed
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


def _play(seed: int, speed: str, folder: Path) -> "ChaosRun":
    """Run one fleet; its folder is kept if the run had trouble or did not arrive."""
    from clew.campaign.campaign import write_drawn
    from clew.campaign.chaos import judge_run, replay_line
    from clew.campaign.episode import drawn_plan_path
    from clew.swarm.swarm import draw

    swarm, path, run = draw(seed), folder / "drawn" / f"{seed}.toml", folder / f"run-{seed}"
    write_drawn(seed, path)
    plan = drawn_plan_path(str(path))
    arguments = [str(path), "--faults", plan, "--seed", str(seed), "--speed", speed, "--out", str(run)]
    ended = run_fleet(arguments, wall_s_max=wall_s_max(swarm.scenario.time.time_s_max, float(speed)))
    load, _, _ = os.getloadavg()
    judged = judge_run(swarm, run, ended, replay=replay_line(path, seed, speed), load=load)
    if judged.troubles or not judged.arrived or judged.not_recovered:
        make_private(run)
        write_whole(run / "stderr.txt", "".join(f"{line}\n" for line in ended.said).encode())
    else:
        shutil.rmtree(run)
    return judged


def _sentence(run: "ChaosRun", number: int, runs: int) -> str:
    what = "arrived" if run.arrived else f"did not arrive: {run.reason}"
    outcome = "; ".join(run.troubles) or run.not_recovered or what
    return f"chaos: {number} of {runs}, seed {run.seed}: {outcome} ({run.wall_s:.0f} s)"


def _print(result: "Chaos", folder: Path) -> None:
    console().print(_table(result.each))
    for run in result.each:
        for trouble in run.troubles:
            say(f"TROUBLE, seed {run.seed}: {trouble}")
        if not run.arrived:
            say(f"did not arrive, seed {run.seed} ({run.mode}): {run.reason}")
        if run.not_recovered:
            say(f"did not recover, seed {run.seed}: {run.not_recovered}")
        if run.troubles or not run.arrived or run.not_recovered:
            say(f"    {to_copy(run.replay)}")
    word = "INTERRUPTED" if result.interrupted else "OK" if result.ok else "FAILED"
    process_faults = ", ".join(f"{fault} {count}" for fault, count in result.process_faults.items())
    click.echo(
        f"{word}: {result.runs} of {result.runs_asked} runs, {result.violations} violations, "
        f"{result.unbalanced} unbalanced, {result.leftovers} left behind, "
        f"{result.not_arrived} did not arrive, {result.not_recovered} of {result.liveness_runs} did not "
        f"recover; {result.messages_sent} messages, {result.messages_unaccounted} unaccounted for; "
        f"process faults: {process_faults or 'none'}. "
        f"Chaos: {folder}"
    )


def _table(runs: "Sequence[ChaosRun]") -> "Table":
    counts = ("arrived", "broken", "sent", "injected", "refused", "lost")
    rest = ("log", "left", "sim, s", "wall, s", "load")
    drawn = numbers_table("seed", "faults", *counts, *rest, left=("faults",))
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
