"""`clew bench scale`: runs fleets of many real processes, and measures what they cost."""

import math
import os
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, PATH, ROBOTS, FiniteRange, speed_option
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.manual_faults import HaltRequest, request_fault
from protocol.frames import FLEETS_MAX
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.live import LiveFleet
    from clew.bench.scale import ScaleRun, Spell

PARTS = ("robot", "world", "router")
LOOK_S = 1.0  # between two looks at all processes: one at 1,000 of them takes 0.1 s


@click.command()
@click.option("-n", "--robots", "fleets", multiple=True, type=ROBOTS, help="Robots of a fleet; repeatable.")
@click.option(
    "--strands",
    type=click.IntRange(1, FLEETS_MAX),
    default=1,
    show_default=True,
    help="Strands among which the robots of each fleet are divided.",
)
@speed_option("Simulated seconds per second, at most.", default=1.0)
@click.option(
    "--stand-s",
    type=FiniteRange(0.0),
    default=3.0,
    show_default=True,
    help="Simulated seconds for which a fleet stands when it has formed.",
)
@click.option(
    "--drive-s",
    type=FiniteRange(0.0, min_open=True),
    help="Simulated seconds after which a fleet that drives is told to end; default: it arrives.",
)
@click.option("--keep", type=PATH, help="Folder to keep the runs in.")
@AS_JSON
@click.pass_context
@terminable()
def scale(
    ctx: click.Context,
    *,
    fleets: tuple[int, ...],
    strands: int,
    speed: float,
    stand_s: float,
    drive_s: float | None,
    keep: Path | None,
    as_json: bool,
) -> None:
    """Run fleets of real processes, one after the other, and measure memory, processor time and lateness.

    Each is a queue that drives over open ground with some posts; with --strands, queues beside each other.
    Default: 5, 50, 200, 500 and 1000 robots; a size that is given twice runs twice. Exits with 1 when a
    verdict is not ok; with --drive-s, when a promise is broken.
    """
    from clew.bench.live import SEED, LiveFleet
    from clew.bench.scale import FLEETS, figures, ground_of

    sizes = fleets or FLEETS
    if uneven := [robots for robots in sizes if robots % strands]:
        raise click.BadParameter(f"{uneven[0]} robots cannot be divided among {strands} strands evenly")
    begun = begin(
        "scale",
        f"Queues of real processes that drive over open ground with some posts, at speed {speed:g} at most. "
        "CPU time is of all processes, per robot and simulated second. A repeat is a run.",
    )
    runs: list[ScaleRun] = []
    with tempfile.TemporaryDirectory(prefix="clew-scale.") as temporary:
        folder = Path(temporary) if keep is None else keep
        for robots in sizes:
            ground, kept = ground_of(robots, strands, seed=SEED), folder / f"{robots}-{len(runs) + 1}"
            runs.append(_run(LiveFleet(ground, kept, speed=speed), speed, stand_s, drive_s or math.inf))
            click.echo(f"{robots} robots: {runs[-1].reason}", err=True)
    begun.say(f"Fleets of real processes on {os.cpu_count()} cores", figures(runs), runs, as_json=as_json)
    ctx.exit(ExitCode.OK if all(run.is_good for run in runs) else ExitCode.FAILED)


def _run(fleet: "LiveFleet", speed: float, stand_s: float, drive_s: float) -> "ScaleRun":
    from clew.bench.live import load
    from clew.bench.scale import scale_run

    load_before = load()
    try:
        standing, driving = _watch(fleet, stand_s, drive_s)
        is_cut_short = driving is not None and driving.sim_s >= drive_s
    finally:
        ended, verdicts = fleet.end()
    return scale_run(
        verdicts,
        fleet.progress,
        robots=fleet.robots,
        strands=len(fleet.folders),
        contacts=fleet.contacts,
        speed=speed,
        began_s=fleet.began_s,
        said=ended.last_words,
        standing=standing,
        driving=driving,
        is_cut_short=is_cut_short,
        load=(load_before, load()),
    )


def _watch(fleet: "LiveFleet", stand_s: float, drive_s: float) -> "tuple[Spell | None, Spell | None]":
    """Let it form, stand and drive, to its goal or for so long; returns what it used meanwhile."""
    standing: Spell | None = None
    if not fleet.until(fleet.progress.has_formed, fleet.start_s_max):
        return None, None
    if stand_s > 0.0:
        try:
            _halt(fleet, stop=True)
            standing = _spell(fleet, stand_s)
            _halt(fleet, stop=False)
        except UsageError:  # it is over already
            return standing, None
        fleet.until(lambda: fleet.progress.has_formed(times=2), fleet.start_s_max)
    return standing, _spell(fleet, drive_s)


def _halt(fleet: "LiveFleet", *, stop: bool) -> None:
    for folder in fleet.folders:
        request_fault(folder, HaltRequest(stop=stop))


def _spell(fleet: "LiveFleet", for_s: float) -> "Spell | None":
    """What the fleet uses in so many simulated seconds from now, or until the run is over."""
    from clew.bench.scale import spell
    from clew.bench.usage import cpu_s, processes, usage_of

    fleet.look()
    pids, progress = fleet.processes, fleet.progress
    first, since_s, since_wall_s = processes(pids), progress.now_s, time.monotonic()
    robots = sum(each.part == "robot" for each in first)
    found: Spell | None = None
    while not (progress.now_s >= since_s + for_s or progress.is_over or fleet.has_ended(LOOK_S)):
        fleet.look()
        last = processes(pids)
        used = {part: usage_of(part, last) for part in PARTS}
        if used["robot"] is None or used["robot"].processes < robots:  # they end: the run is over
            break
        found = spell(
            cpu_s(first, last),
            robots=fleet.robots,
            sim_s=progress.now_s - since_s,
            wall_s=time.monotonic() - since_wall_s,
            used=used,
        )
    return found
