"""`clew bench healing`: what is measured on real fleets, at real time."""

import os
import sys
import tempfile
from pathlib import Path

import click
import msgspec
from rich.console import Console
from rich.table import Table

from clew.bench.healing import Healing, HealingFigures, LeaderBlow, Times, figures_of, healing_in
from clew.fleet.live import run_fleet
from clew.log.timeline import read
from clew.verbs.options import AS_JSON
from clew.verbs.say import warn
from protocol.asked import terminable
from protocol.exit_codes import ExitCode
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import load

HEALED = b'"kind":"strand.healed"'  # as the recorder writes it
PIPE_COLUMNS = 140  # the table's width where stdout is no terminal
WALL_S_MAX = 60.0  # of a run: the strand has healed within 10 s, or it does not


@click.command()
@click.argument("scenario", default="grove")
@click.option("--runs", type=click.IntRange(1, 1000), default=20, show_default=True, help="Of each blow.")
@AS_JSON
@click.pass_context
@terminable()
def healing(ctx: click.Context, scenario: str, *, runs: int, as_json: bool) -> None:
    """Kill, and then freeze, leaders of live fleets at real time; how soon are they missed and succeeded?

    A run is told to end when its strand has healed.

    Exit code: 0 all times within their bounds, 1 one was not, or never came, 2 it cannot be done as asked,
    130, 143 or 129 ended by Ctrl-C, SIGTERM or SIGHUP, and so was its fleet.
    """
    load(scenario)  # what cannot be loaded is said before fleets start, not by each of them
    rows: list[HealingFigures] = []
    for blow in LeaderBlow:
        measured: list[Healing | None] = []
        loads: list[float] = []
        for run in range(runs):
            measured.append(_measure(scenario, blow, run))
            loads.append(os.getloadavg()[0])
            click.echo(f"{blow} {run + 1} of {runs}: {measured[-1]}", err=True)
        rows.append(figures_of(blow, measured, loads))
    if as_json:
        click.echo(msgspec.json.format(msgspec.json.encode(rows)).decode())
    else:
        _print(rows)
    ctx.exit(ExitCode.OK if all(row.ok for row in rows) else ExitCode.FAILED)


def _measure(scenario: str, blow: LeaderBlow, run: int) -> Healing | None:
    with tempfile.TemporaryDirectory(prefix="clew-healing.") as folder:
        plan, out = Path(folder) / FAULTS_FILE, Path(folder) / "run"
        plan.write_text(plan_text(blow.plan(run)), encoding="utf-8")
        events = out / EVENTS_FILE
        ended = run_fleet(
            [scenario, "--faults", str(plan), "--seed", str(run + 1), "--out", str(out)],
            wall_s_max=WALL_S_MAX,
            until=lambda: events.exists() and HEALED in events.read_bytes(),
        )
        if not events.exists():
            warn(f"no run: {'; '.join(ended.said)}")
            return None
        return healing_in(read(out).lines)


def _print(rows: list[HealingFigures]) -> None:
    table = Table(
        title="From the blow to detection, from there to succession, from the blow to healing [wall s]"
    )
    table.add_column("leader")
    for column in (
        "runs",
        "never",
        "detection p50",
        "p99",
        "bound",
        "succession p50",
        "p99",
        "bound",
        "healed p50",
    ):
        table.add_column(column, justify="right")
    for row in rows:
        cells = (*_cells(row.detection), *_cells(row.succession), _cells(row.healed)[0])
        table.add_row(f"{row.blow}", f"{row.runs}", f"{row.never}", *cells)
    console = Console() if sys.stdout.isatty() else Console(width=PIPE_COLUMNS)
    console.print(table)
    loads = [load for row in rows for load in row.loads]
    word = "OK" if all(row.ok for row in rows) else "FAILED"
    click.echo(f"{word}; load of the machine {min(loads):.1f} to {max(loads):.1f} on {os.cpu_count()} cores.")


def _cells(times: Times | None) -> tuple[str, str, str]:
    if times is None:
        return "-", "-", "-"
    return f"{times.p50_s:.3f}", f"{times.p99_s:.3f}", "-" if times.bound_s is None else f"{times.bound_s:g}"
