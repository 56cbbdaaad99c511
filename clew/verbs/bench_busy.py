"""`clew bench busy`: runs live fleets beside processes that keep the machine busy."""

import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.fleet.live import run_fleet
from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, FiniteRange, robots_option
from protocol.exit_codes import ExitCode
from protocol.files.toml_text import toml_text
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.busy import BusyRun

BUSY_MAX = 200
QUEUE = "queue"
COMPUTES = "while True: pass"
QUEUE_S_MAX = 1800.0  # of a run: fifty robots beside 16 busy processes on two cores took 160 s


@click.command()
@click.argument("scenario", default="grove")
@robots_option("Robots of each fleet.")
@click.option(
    "--processes",
    type=click.IntRange(0, BUSY_MAX),
    default=16,
    show_default=True,
    help="Number of busy processes.",
)
@click.option(
    "--for-s",
    type=FiniteRange(1.0),
    default=60.0,
    show_default=True,
    help="Start no fleet after this time [wall-clock s].",
)
@AS_JSON
@click.pass_context
@terminable()
def busy(
    ctx: click.Context, scenario: str, *, robots: int | None, processes: int, for_s: float, as_json: bool
) -> None:
    """Run live fleets beside busy processes, one after the other, and count the robots declared dead.

    SCENARIO is one of `clew rehearse`, or `queue`: robots in a straight queue on open ground. Exits with 1
    when a robot was declared dead, a promise was broken, or not all robots arrived.
    """
    from clew.bench.busy import figures
    from clew.bench.result import all_met

    _check(scenario, robots)
    begun = begin("busy", f"Live fleets on {scenario} beside {processes} busy processes. A repeat is a run.")
    runs: list[BusyRun] = []
    with tempfile.TemporaryDirectory(prefix="clew-busy.") as folder, _busy(processes):
        arguments = _arguments(scenario, robots, Path(folder))
        while sum(run.launcher_s for run in runs) < for_s:
            runs.append(_run(arguments, Path(folder) / f"run-{len(runs) + 1}", len(runs) + 1))
            click.echo(f"{len(runs)}: {runs[-1]}", err=True)
    found = figures(runs)
    begun.say(f"Live fleets beside {processes} busy processes", found, runs, as_json=as_json)
    ctx.exit(ExitCode.OK if all_met(found) else ExitCode.FAILED)


def _check(scenario: str, robots: int | None) -> None:
    """Refuse a scenario with which no run would start, before the machine is kept busy."""
    from world.scenario.fleets import has_several, load_fleets
    from world.scenario.scenario import load

    if scenario != QUEUE:
        (load_fleets if has_several(scenario) else load)(scenario, robots=robots)


def _arguments(scenario: str, robots: int | None, folder: Path) -> list[str]:
    from clew.bench.forming import queue

    if scenario == QUEUE:
        path = folder / "queue.toml"
        path.write_text(toml_text(msgspec.to_builtins(queue(robots or 5))), encoding="utf-8")
        return [str(path)]
    return [scenario] if robots is None else [scenario, "-n", str(robots)]


@contextlib.contextmanager
def _busy(processes: int) -> Iterator[None]:
    """So many processes compute while the context lasts.

    Each has a session of its own: Linux shares the processor among sessions, and all of them in one would
    take no more than a single one.
    """
    with contextlib.ExitStack() as stack:
        for _ in range(processes):
            command = [sys.executable, "-ISc", COMPUTES]
            process = subprocess.Popen(command, start_new_session=True)  # noqa: S603 - a loop of our own
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield


def _run(arguments: list[str], out: Path, seed: int) -> "BusyRun":
    from clew.bench.busy import busy_run
    from clew.fleet.runs import verdict_in
    from world.judge.verdict import Verdict

    ended = run_fleet([*arguments, "--seed", str(seed), "--out", str(out)], wall_s_max=QUEUE_S_MAX)
    return busy_run(verdict_in(out, Verdict), ended.last_words, launcher_s=ended.wall_s)
