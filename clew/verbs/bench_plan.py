"""`clew bench plan`: times the plans of leaders. It is the shell: it reads the clocks."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.files.reading import understand

if TYPE_CHECKING:
    from clew.bench.plan import PlanFigures, Sample
    from world.scenario.scenario import Scenario

FIELD_SEED = 1  # of the fields that are measured by default


@click.command()
@click.option(
    "--scenes",
    "roots",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Folder or file with scenes; repeatable. Default: a field of each kind, as `clew field` prints it.",
)
@AS_JSON
def plan(roots: tuple[Path, ...], *, as_json: bool) -> None:
    """Time every plan that the leaders of some rehearsals make, as a whole and by part.

    For comparison, a textbook planner plans on the same scans: a distance transform, then Dijkstra's
    algorithm over all open cells of a grid as fine as the leader's. It certifies nothing.
    """
    from clew.bench.plan import figure_of, figures, samples

    begun = begin(
        "plan", "CPU time of each plan of a leader, and of a textbook grid planner on the same scan."
    )
    names: list[str] = []
    measured: list[Sample] = []
    for name, scenario in _asked(roots) if roots else _fields():
        if scenario.mission().goal is None:
            raise UsageError(f"{name}: has no goal, but the textbook planner needs one")
        names.append(name)
        measured += samples(scenario, cpu=time.process_time, wall=time.perf_counter)
        click.echo(f"{name}: {len(measured)} plans so far", err=True)
    if not measured:
        raise UsageError(f"no leader made a plan in {', '.join(names)}")
    found = figures(names, measured)
    if as_json:
        begun.say_json([figure_of(found)], found)
    else:
        _print(found)


def _asked(roots: Sequence[Path]) -> "Iterator[tuple[str, Scenario]]":
    from clew.campaign.scenes import find_scenes
    from world.scenario.scenario import load

    for found in find_scenes(roots, None, warn):
        yield str(found.path), load(str(found.path))


def _fields() -> "Iterator[tuple[str, Scenario]]":
    from clew.fields.field import BUILDERS, Field, scene
    from clew.fields.kinds import Kind
    from world.scenario.scenario import Scenario
    from world.scenario.scene import as_scenario

    for kind in (kind for kind in Kind if kind not in BUILDERS):
        name = f"field {kind} --seed {FIELD_SEED}"
        field = scene(Field(kind=kind, seed=FIELD_SEED))
        yield name, understand(as_scenario(field, name), Scenario, name)


def _print(found: "PlanFigures") -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"{found.plans} plans of {len(found.scenes)} scenes [ms]")
    table.add_column("")
    for column in ("median", "90 %", "longest"):
        table.add_column(column, justify="right")
    parts = {f"  {part}": spread for part, spread in found.parts_cpu.items()}
    rows = {
        "plan, wall": found.plan_wall,
        "plan, CPU": found.plan_cpu,
        **parts,
        "textbook, CPU": found.textbook_cpu,
    }
    for name, spread in rows.items():
        table.add_row(name, f"{spread.median_ms:.2f}", f"{spread.p90_ms:.2f}", f"{spread.max_ms:.2f}")
    Console().print(table)
    click.echo(f"The median plan takes {found.ratio:.2f} times as long as that of the textbook planner.")
