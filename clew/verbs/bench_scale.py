"""`clew bench scale`: runs fleets of many real processes, and measures what they cost."""

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.fleet.live import Launched
from clew.verbs.bench_said import begin, print_figures
from clew.verbs.options import AS_JSON, ROBOTS
from protocol.asked import terminable
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.manual_faults import HaltRequest, request_fault
from protocol.files.toml_text import toml_text
from protocol.run_settings import SPEED_MAX

if TYPE_CHECKING:
    from clew.bench.scale import Progress, ScaleRun, Spell

START_WALL_S, START_WALL_S_PER_ROBOT = 60.0, 0.5  # as the world waits, and some time to form
SEED = 1
PARTS = ("robot", "world", "router")
LOOK_S = 1.0  # between two looks at all processes: one at 1,000 of them takes 0.1 s


@click.command()
@click.option("-n", "--robots", "fleets", multiple=True, type=ROBOTS, help="Robots of a fleet; repeatable.")
@click.option(
    "--speed",
    type=click.FloatRange(0.0, SPEED_MAX, min_open=True),
    default=1.0,
    show_default=True,
    help="Simulated seconds per second, at most.",
)
@click.option(
    "--stand-s",
    type=click.FloatRange(0.0),
    default=3.0,
    show_default=True,
    help="Simulated seconds for which a fleet stands when it has formed.",
)
@click.option("--keep", type=click.Path(path_type=Path), help="Folder to keep the runs in.")
@AS_JSON
@click.pass_context
@terminable()
def scale(
    ctx: click.Context,
    *,
    fleets: tuple[int, ...],
    speed: float,
    stand_s: float,
    keep: Path | None,
    as_json: bool,
) -> None:
    """Run fleets of real processes, one after the other, and measure memory, processor time and lateness.

    Each is a queue that drives over open ground with some posts. Default: 5, 50, 200, 500 and 1000 robots; a
    size that is given twice runs twice. Exits with 1 when a verdict is not ok.
    """
    from clew.bench.scale import FLEETS, figures

    begun = begin(
        "scale",
        f"Queues of real processes that drive over open ground with some posts, at speed {speed:g} at most. "
        "CPU time is of all processes, per robot and simulated second. A repeat is a run.",
    )
    runs: list[ScaleRun] = []
    with tempfile.TemporaryDirectory(prefix="clew-scale.") as temporary:
        folder = Path(temporary) if keep is None else keep
        for robots in fleets or FLEETS:
            runs.append(_run(robots, speed, stand_s, folder / f"{robots}-{len(runs) + 1}"))
            click.echo(f"{robots} robots: {runs[-1].reason}", err=True)
    if as_json:
        begun.say_json(figures(runs), runs)
    else:
        print_figures(f"Fleets of real processes on {os.cpu_count()} cores", figures(runs))
    ctx.exit(ExitCode.OK if all(run.ok for run in runs) else ExitCode.FAILED)


def _run(robots: int, speed: float, stand_s: float, folder: Path) -> "ScaleRun":
    from clew.bench.scale import Progress, queue_before_posts, scale_run
    from world.judge.verdict import VERDICT_FILE
    from world.record.run_files import read_verdict

    folder.mkdir(parents=True)
    path, out = folder / "queue.toml", folder / "run"
    scenario = queue_before_posts(robots, seed=SEED)
    path.write_text(toml_text(msgspec.to_builtins(scenario)), encoding="utf-8")
    command = [sys.executable, "-m", "clew.cli", "run", str(path), "--out", str(out), "--quiet"]
    load, began_s, progress = os.getloadavg()[0], time.time(), Progress(robots)
    launched = Launched([*command, "--speed", str(speed), "--seed", str(SEED)])
    try:
        fleet = _Watched(launched, out, progress, robots)
        standing, driving = fleet.watch(stand_s)
    finally:
        ended = launched.end()
    return scale_run(
        read_verdict(out) if (out / VERDICT_FILE).exists() else None,
        progress,
        robots=robots,
        speed=speed,
        began_s=began_s,
        said=ended.said[-1] if ended.said else "it said nothing",
        standing=standing,
        driving=driving,
        load=(load, os.getloadavg()[0]),
    )


class _Watched:
    """A fleet that runs."""

    def __init__(self, launched: Launched, out: Path, progress: "Progress", robots: int) -> None:
        self._launched, self._out, self._progress, self._robots = launched, out, progress, robots
        self._read_bytes = 0

    def watch(self, stand_s: float) -> "tuple[Spell | None, Spell | None]":
        """Let it form, stand and drive to its goal; returns what it used while it stood, and drove."""
        start_s = START_WALL_S + START_WALL_S_PER_ROBOT * self._robots
        standing: Spell | None = None
        if not self._until(lambda: self._progress.joined >= self._robots, start_s):
            return None, None
        if stand_s > 0.0:
            try:
                request_fault(self._out, HaltRequest(stop=True))
                standing = self._spell(lambda since_s: self._progress.now_s >= since_s + stand_s)
                request_fault(self._out, HaltRequest(stop=False))
            except UsageError:  # it is over already
                return standing, None
            self._until(lambda: self._progress.joined >= 2 * self._robots, start_s)
        return standing, self._spell(lambda _: False)

    def _spell(self, is_over: "Callable[[float], bool]") -> "Spell | None":
        """What the fleet uses from now until that is so of the time of the beginning, or the run is over."""
        from clew.bench.scale import spell
        from clew.bench.usage import cpu_s, processes, usage_of

        self._look()
        pids = self._launched.processes
        first, since_s, since_wall_s = processes(pids), self._progress.now_s, time.monotonic()
        found: Spell | None = None
        while not (is_over(since_s) or self._progress.is_over):
            if self._launched.has_ended(LOOK_S):
                break
            self._look()
            last = processes(pids)
            used = {part: usage_of(part, last) for part in PARTS}
            if used["robot"] is None:  # they have ended since the look at the timeline
                break
            found = spell(
                cpu_s(first, last),
                robots=self._robots,
                sim_s=self._progress.now_s - since_s,
                wall_s=time.monotonic() - since_wall_s,
                used=used,
            )
        return found

    def _until(self, is_so: "Callable[[], bool]", wall_s_max: float) -> bool:
        """Whether that is so within this time, before the fleet ends."""
        until_s = time.monotonic() + wall_s_max
        while not is_so():
            if self._launched.has_ended() or time.monotonic() > until_s:
                return False
            self._look()
        return True

    def _look(self) -> None:
        events = self._out / "events.jsonl"
        if events.exists():
            with events.open("rb") as file:
                file.seek(self._read_bytes)
                piece = file.read()
            self._read_bytes += len(piece)
            self._progress.read(piece)
