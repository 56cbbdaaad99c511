"""`clew bench plan`: times the plans of leaders. It is the shell: it reads the clocks."""

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.bench_said import begin
from clew.verbs.extras import install_line
from clew.verbs.options import AS_JSON, PATH, runs_option
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.mission import RAYS_MAX

if TYPE_CHECKING:
    from clew.bench.plan import Peers, PlanFigures, Planner, Sample
    from protocol.mission import Mission
    from world.scenario.scenario import Scenario

FIELD_SEED = 1  # of the fields that are measured by default
SCANS_MAX = 1000


@click.command()
@click.option(
    "--scenes",
    "roots",
    multiple=True,
    type=PATH,
    help="Folder or file with scenes; repeatable. Default: a field of each kind, as `clew field` prints it.",
)
@click.option(
    "--directions",
    multiple=True,
    type=click.IntRange(8, RAYS_MAX),
    help="Rays of a revolution, instead of the scenes'; repeatable.",
)
@click.option(
    "--scans",
    "sizes",
    multiple=True,
    type=click.IntRange(1, SCANS_MAX),
    help="Also plan in a map of so many scans of a wide field; repeatable.",
)
@runs_option("How often to plan it all.", default=1)
@AS_JSON
def plan(
    roots: tuple[Path, ...],
    directions: tuple[int, ...],
    sizes: tuple[int, ...],
    runs: int,
    *,
    as_json: bool,
) -> None:
    """Time every plan that the leaders of some rehearsals make, as a whole and by part.

    For comparison, a textbook planner plans on the same scans: a distance transform, then Dijkstra's
    algorithm over all open cells of a grid as fine as the leader's. It certifies nothing. Two local planners
    of others plan on them, too: the dynamic-window approach and, with the extra `peers`, ORCA. They choose
    velocities for 0.1 s and remember nothing.
    """
    from clew.bench.plan import common

    begun = begin(
        "plan",
        "CPU time of each plan of a leader, and of other planners on the same scan: a textbook grid planner, "
        "and two that choose velocities for the next 0.1 s (the dynamic-window approach, ORCA).",
    )
    peers = _peers()
    scenes = list(_asked(roots) if roots else _fields())
    for name, scenario in scenes:
        if scenario.mission().goal is None:
            raise UsageError(f"{name}: has no goal, but the textbook planner needs one")
    found, figures = [], []
    for rays in directions or (None,):
        repeats = [_measured(scenes, rays, peers) for _ in range(runs)]
        found += repeats
        figures += common("as the scenes are" if rays is None else f"{rays} directions", repeats)
    for size, repeats in _grown(sizes, runs):
        found += repeats
        figures += common(f"a map of {size} scans", repeats)[:1]
    begun.say("A plan beside the textbook planner's", figures, found, as_json=as_json)


def _peers() -> "Peers":
    """The planners of others; one that is not installed is left out."""
    from clew.bench.planners.window import Window

    peers: dict[str, Callable[[Mission], Planner]] = {"dynamic window": Window}
    try:
        from clew.bench.planners.orca import Orca
    except ImportError:
        warn(f"ORCA is not measured: the extra `peers` is not installed: {install_line('peers')}")
        return peers
    return peers | {"ORCA": Orca}


def _grown(sizes: Sequence[int], runs: int) -> "Iterator[tuple[int, list[PlanFigures]]]":
    """All plans in maps of these sizes."""
    from clew.bench.plan import figures
    from clew.bench.planners.growing import field, samples, views

    if sizes:
        scenario = field()
        seen = views(scenario, max(sizes))
        for size in sizes:
            repeats = [samples(scenario, seen, size, cpu=time.process_time) for _ in range(runs)]
            yield size, [figures([f"a map of {size} scans"], each) for each in repeats]


def _measured(scenes: "Sequence[tuple[str, Scenario]]", rays: int | None, peers: "Peers") -> "PlanFigures":
    """All plans of the scenes, once."""
    from clew.bench.plan import figures, samples

    measured: list[Sample] = []
    for name, scenario in scenes:
        sensor = scenario.sensor
        sensor = sensor if rays is None else msgspec.structs.replace(sensor, directions=rays)
        asked = msgspec.structs.replace(scenario, sensor=sensor)
        measured += samples(asked, cpu=time.process_time, wall=time.perf_counter, peers=peers)
        click.echo(f"{name}: {len(measured)} plans so far", err=True)
    names = [name for name, _ in scenes]
    if not measured:
        raise UsageError(f"no leader made a plan in {', '.join(names)}")
    return figures(names, measured)


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
