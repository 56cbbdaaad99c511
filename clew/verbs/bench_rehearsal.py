"""`clew bench rehearsal`: times whole rehearsals. It is the shell: it reads the clocks."""

import time

import click

from clew.verbs.bench_said import begin, print_figures
from clew.verbs.options import AS_JSON, runs_option
from protocol.faults.plan import NO_FAULTS, uniform
from protocol.faults.plan import load as load_plan

LOSS = 0.3


@click.command()
@click.argument("scenario", default="grove")
@runs_option("How many rehearsals of each fault plan to time.", default=5)
@click.option(
    "--faults",
    "plans",
    multiple=True,
    help="Fault plan, a name or a file; repeatable. Default: no faults, 30 % loss, and the leader killed.",
)
@AS_JSON
def rehearsal(scenario: str, runs: int, plans: tuple[str, ...], *, as_json: bool) -> None:
    """Time whole rehearsals: simulated seconds per wall-clock second.

    For comparison, the same number of ticks and messages is timed with cores that do nothing.
    """
    from clew.bench.rehearsal import figure_of, speed
    from world.scenario.scenario import load

    known = load(scenario)
    asked = [load_plan(each) for each in plans] or [NO_FAULTS, uniform(loss=LOSS), load_plan("leader-killed")]
    title = f"Rehearsals of {known.name} with {known.fleet.robots} robots"
    begun = begin("rehearsal", f"{title}: simulated seconds per wall-clock second. A repeat is a rehearsal.")
    rows = [speed(known, plan, runs=runs, wall=time.perf_counter) for plan in asked]
    figures = [figure_of(row) for row in rows]
    if as_json:
        begun.say_json(figures, rows)
    else:
        print_figures(title, figures)
