"""`clew bench healing`: measures on live fleets, in real time."""

import os
import re
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.fleet.live import run_fleet
from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, runs_option
from clew.verbs.say import warn
from protocol.exit_codes import ExitCode
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.healing import Healing, LeaderFault

DRIVES_AGAIN = re.compile(rb'"kind":"strand.healed"(?s:.)*"kind":"order.accepted"[^\n]*"step":[1-9]')
"""The leader's first order after a heal, as the recorder writes it."""
WALL_S_MAX = 60.0  # of a run: a strand heals within 10 s, or never


@click.command()
@click.argument("scenario", default="grove")
@runs_option("How many runs with each fault.", default=20)
@AS_JSON
@click.pass_context
@terminable()
def healing(ctx: click.Context, scenario: str, *, runs: int, as_json: bool) -> None:
    """Measure how soon live fleets detect and replace a lost leader.

    In half of the runs the leader is killed, in the other half it is frozen. Each run ends as soon as its
    strand drives again. Exits with 1 when a time was over its bound or an event never came.
    """
    from clew.bench.healing import HealingRuns, LeaderFault, figures
    from clew.bench.result import all_met
    from world.scenario.scenario import load

    begun = begin(
        "healing", f"Live fleets on {scenario} lose their leader; wall-clock times. A repeat is a run."
    )
    load(scenario)  # report a bad scenario once, before any fleet starts
    rows: list[HealingRuns] = []
    for fault in LeaderFault:
        measured: list[Healing | None] = []
        loads: list[float] = []
        for run in range(runs):
            measured.append(_measure(scenario, fault, run))
            loads.append(os.getloadavg()[0])
            click.echo(f"{fault} {run + 1} of {runs}: {measured[-1]}", err=True)
        rows.append(HealingRuns(fault=fault, loads=tuple(loads), each=tuple(measured)))
    found = [each for row in rows for each in figures(row)]
    begun.say("Live fleets that lose their leader [wall-clock s]", found, rows, as_json=as_json)
    ctx.exit(ExitCode.OK if all_met(found) else ExitCode.FAILED)


def _measure(scenario: str, fault: "LeaderFault", run: int) -> "Healing | None":
    from clew.bench.healing import healing_in
    from clew.log.timeline import read
    from world.record.recorder import EVENTS_FILE

    with tempfile.TemporaryDirectory(prefix="clew-healing.") as folder:
        plan, out = Path(folder) / FAULTS_FILE, Path(folder) / "run"
        plan.write_text(plan_text(fault.plan(run)), encoding="utf-8")
        events = out / EVENTS_FILE
        ended = run_fleet(
            [scenario, "--faults", str(plan), "--seed", str(run + 1), "--out", str(out)],
            wall_s_max=WALL_S_MAX,
            until=lambda: events.exists() and DRIVES_AGAIN.search(events.read_bytes()) is not None,
        )
        if not events.exists():
            warn(f"no run: {'; '.join(ended.said)}")
            return None
        return healing_in(read(out).lines)
