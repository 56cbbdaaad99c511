"""`clew bench loss`: measures how message loss delays a fleet."""

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.fleet.live import run_fleet
from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, SPEED, runs_option, wall_s_max
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.loss import Crossing
    from world.scenario.scenario import Scenario


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
@AS_JSON
@click.pass_context
@terminable()
def loss(ctx: click.Context, scenario: str, *, runs: int, live: int, speed: float, as_json: bool) -> None:
    """Measure how long a fleet takes when 0 to 90 % of its messages are lost.

    Each rate is measured twice: for messages between robots only, and for all messages. Exits with 1 when a
    promise was broken, or when loss between robots made the fleet take more than 1.1 times as long (at 50 %)
    or 1.5 times (at 75 %), or kept it from arriving at all (at any rate).
    """
    from clew.bench.loss import RATES, LossPoint, Reach, figures, loss_plan, rehearsed
    from clew.bench.result import all_met
    from world.scenario.scenario import load

    known = load(scenario)
    begun = begin(
        "loss", f"Time until {known.fleet.robots} robots have crossed {known.name}. A repeat is a seed."
    )
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
    begun.say(f"{known.fleet.robots} robots cross {known.name}", found, points, as_json=as_json)
    ctx.exit(ExitCode.OK if all_met(found) else ExitCode.FAILED)


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


def _times(crossings: "tuple[Crossing, ...]") -> str:
    return (
        " ".join("never" if each.time_s is None else f"{each.time_s:.1f}" for each in crossings) or "not run"
    )
