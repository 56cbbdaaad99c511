"""`clew bench loss`: measures how message loss delays a fleet."""

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.fleet.live import run_fleet
from clew.verbs.bench_said import begin
from clew.verbs.extras import need
from clew.verbs.options import AS_JSON, SPEED, runs_option, wall_s_max
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.process.asked import terminable
from protocol.root import ROOT

if TYPE_CHECKING:
    from clew.bench.loss import Crossing, LossPoint
    from clew.bench.result import Figure
    from world.scenario.scenario import Scenario

DOCUMENT = ROOT / "docs" / "measured.md"
PART, FIGURE = "loss", DOCUMENT.with_name("loss.svg")


@click.command()
@click.argument("scenario", default="grove")
@runs_option("How many rehearsals for each rate of loss.", default=5)
@click.option(
    "--live",
    type=click.IntRange(0, 100),
    default=0,
    show_default=True,
    help="How many live fleets for each rate of loss.",
)
@SPEED
@click.option(
    "--write", is_flag=True, help="Write the table into docs/measured.md, and the figure docs/loss.svg."
)
@AS_JSON
@click.pass_context
@terminable()
def loss(
    ctx: click.Context, scenario: str, *, runs: int, live: int, speed: float, write: bool, as_json: bool
) -> None:
    """Measure how long a fleet takes when 0 to 90 % of its messages are lost.

    Each rate is measured twice: for messages between robots only, and for all messages. Exits with 1 when a
    promise was broken, or when loss between robots made the fleet take more than 1.1 times as long (at 50 %)
    or 1.5 times (at 75 %), or kept it from arriving at all (at any rate).
    """
    from clew.bench.loss import RATES, LossPoint, Reach, figures, loss_plan, rehearsed
    from clew.bench.result import all_met
    from clew.manual.parts import with_part
    from world.scenario.scenario import load

    known = load(scenario)
    begun = begin(
        "loss", f"Time until {known.fleet.robots} robots have crossed {known.name}. A repeat is a seed."
    )
    if write:
        need("matplotlib", extra="plot", by="figures need")  # fail before the runs, not after them
    points: list[LossPoint] = []
    for reach in Reach:
        for rate in RATES:
            plan = loss_plan(reach, rate)
            point = LossPoint(
                reach=reach,
                rate=rate,
                rehearsed=tuple(rehearsed(known, plan, seed) for seed in range(1, runs + 1)),
                live=tuple(_live(scenario, known, plan, seed, speed) for seed in range(1, live + 1)),
            )
            points.append(point)
            click.echo(f"{reach}, {rate:g}: {_times(point.rehearsed)}; live {_times(point.live)}", err=True)
    found = figures(points)
    said = _said(known, points, found, runs=runs, speed=speed)
    if write:
        _draw(points, f"{known.fleet.robots} robots, {known.name}")
        DOCUMENT.write_text(with_part(DOCUMENT.read_text(encoding="utf-8"), PART, said), encoding="utf-8")
    begun.say_json(found, points) if as_json else click.echo(said)
    ctx.exit(ExitCode.OK if all_met(found) else ExitCode.FAILED)


def _draw(points: "list[LossPoint]", title: str) -> None:
    from clew.bench.loss_chart import loss_chart
    from clew.figures.style import render

    FIGURE.write_bytes(render(loss_chart(points, title), ("svg",))["svg"])


def _live(scenario: str, known: "Scenario", plan: Plan, seed: int, speed: float) -> "Crossing":
    from clew.bench.loss import Crossing
    from clew.fleet.runs import verdict_in
    from world.judge.ending import Ending
    from world.judge.verdict import Verdict

    with tempfile.TemporaryDirectory(prefix="clew-loss.") as folder:
        path, out = Path(folder) / FAULTS_FILE, Path(folder) / "run"
        path.write_text(plan_text(plan), encoding="utf-8")
        arguments = ["--faults", str(path), "--seed", str(seed), "--speed", f"{speed:g}", "--out", str(out)]
        ended = run_fleet([scenario, *arguments], wall_s_max=wall_s_max(known.time.time_s_max, speed))
        if (verdict := verdict_in(out, Verdict)) is None:
            raise UsageError(f"a live run has no verdict: {'; '.join(ended.said[-3:])}")
    return Crossing(
        seed=seed,
        time_s=verdict.sim_s if verdict.reason == Ending.ARRIVED else None,
        violations=verdict.violations,
        load=os.getloadavg()[0],
    )


def _said(
    known: "Scenario", points: "list[LossPoint]", found: "list[Figure]", *, runs: int, speed: float
) -> str:
    """The table, and how it was measured."""
    from clew.bench.loss import table
    from clew.bench.page import said_aim, said_number

    crossings = [each for point in points for each in (*point.rehearsed, *point.live)]
    broken = sum(each.violations for each in crossings)
    loads = [each.load for each in crossings if each.load is not None]
    load = f", load {min(loads):.1f} to {max(loads):.1f} on {os.cpu_count()} cores" if loads else ""
    slower = ((each, base.ratio) for each in found if each.aim for base in each.baselines if each.aim.of)
    times = "; ".join(
        f"{each.name}: {said_number(ratio.median, 's')} times ({said_aim(each.aim)})"
        for each, ratio in slower
    )
    live = f"; live at speed {speed:g}{load}" if loads else ""
    return (
        f"{known.fleet.robots} robots cross `{known.name}`: simulated seconds until all have arrived; "
        f"*never*: not within {known.time.time_s_max:g} s.\nRehearsed with seeds 1 to {runs}{live}.\n"
        f"In {len(crossings)} runs, {broken} promises were broken. "
        f"{times}.\n\n{table(points)}"
    )


def _times(crossings: "tuple[Crossing, ...]") -> str:
    return (
        " ".join("never" if each.time_s is None else f"{each.time_s:.1f}" for each in crossings) or "not run"
    )
