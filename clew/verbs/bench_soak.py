"""`clew bench soak`: kills and restarts robots of a live fleet, and measures whether anything grows."""

import contextlib
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin
from clew.verbs.options import AS_JSON, PATH, ROBOTS, FiniteRange, speed_option
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.manual_faults import FaultRequest, request_fault
from protocol.faults.rules import Restart
from protocol.keys import WORLD, robot_name
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.bench.live import LiveFleet
    from clew.bench.soak import Look, Probe, Soak

SOME_S = FiniteRange(0.0, min_open=True)
BACK_S_MAX = 30.0  # wall: until all robots that were killed last are back


@click.command()
@click.option("-n", "--robots", type=ROBOTS, default=200, show_default=True, help="Robots of the fleet.")
@click.option(
    "--for-s", type=SOME_S, default=600.0, show_default=True, help="How long to go on once it has formed."
)
@click.option("--every-s", type=SOME_S, default=2.0, show_default=True, help="Time between two restarts.")
@click.option("--probe-s", type=SOME_S, default=5.0, show_default=True, help="Time between two new sessions.")
@click.option(
    "--look-s", type=SOME_S, default=5.0, show_default=True, help="Time between two looks at memory."
)
@speed_option("Simulated seconds per second, at most.", default=1.0)
@click.option("--keep", type=PATH, help="Folder to keep the run in.")
@AS_JSON
@click.pass_context
@terminable()
def soak(
    ctx: click.Context,
    *,
    robots: int,
    for_s: float,
    every_s: float,
    probe_s: float,
    look_s: float,
    speed: float,
    keep: Path | None,
    as_json: bool,
) -> None:
    """Kill and restart one robot after the other in a live fleet, and measure what grows.

    All times are wall-clock times. Exits with 1 when a bound is passed: memory, descriptors or the
    router's sessions grow, a new session is not admitted, a promise is broken, a robot does not come back.
    """
    from clew.bench.result import all_met
    from clew.bench.soak import figures

    begun = begin(
        "soak",
        f"{robots} real robots; each {every_s:g} s one is killed and started again, each {probe_s:g} s a new "
        "session is opened at the router. Growth is from the second to the last third of the time.",
    )
    with tempfile.TemporaryDirectory(prefix="clew-soak.") as temporary:
        folder = (Path(temporary) if keep is None else keep) / f"soak-{robots}"
        found = _Soaking(robots, folder, speed, every_s=every_s, probe_s=probe_s, look_s=look_s).soak(for_s)
    click.echo(f"{found.restarts} restarts in {found.soaked_s:.0f} s: {found.said}", err=True)
    rows = figures(found)
    title = f"{robots} robots, of which one is killed each {every_s:g} s"
    begun.say(title, rows, found, as_json=as_json)
    ctx.exit(ExitCode.OK if all_met(rows) else ExitCode.FAILED)


class _Soaking:
    """One soak."""

    def __init__(
        self, robots: int, folder: Path, speed: float, *, every_s: float, probe_s: float, look_s: float
    ) -> None:
        from clew.bench.soak import targets

        self._robots, self._folder, self._speed = robots, folder, speed
        self._every_s, self._probe_s, self._look_s = every_s, probe_s, look_s
        self._targets = targets(robots)
        self._restarts = 0
        self._looks: list[Look] = []
        self._probes: list[Probe] = []

    def soak(self, for_s: float) -> "Soak":
        """Start a fleet, soak it for so long, and end it."""
        from clew.bench.live import LiveFleet, load
        from clew.bench.soak import Soak, endless_queue

        load_before, soaked_s, missing = load(), 0.0, self._robots
        scenario = endless_queue(self._robots, wall_s=for_s, speed=self._speed)
        fleet = LiveFleet(scenario, self._folder, speed=self._speed)
        try:
            if fleet.until(fleet.progress.has_formed, fleet.start_s_max):
                soaked_s = self._go_on(fleet, for_s)
                fleet.until(lambda: self._missing(fleet) == 0, BACK_S_MAX)
                missing = self._missing(fleet)
        finally:
            ended, verdicts = fleet.end()
        verdict = next(iter(verdicts), None)
        return Soak(
            robots=self._robots,
            asked_s=for_s,
            soaked_s=soaked_s,
            restarts=self._restarts,
            looks=tuple(self._looks),
            probes=tuple(self._probes),
            missing=missing,
            violations=None if verdict is None else verdict.violations,
            said=ended.last_words if verdict is None else verdict.reason,
            load=(load_before, load()),
        )

    def _go_on(self, fleet: "LiveFleet", for_s: float) -> float:
        """Restart, probe and look in turn; returns for how long the fleet went on."""
        since_s = time.monotonic()
        due = {self._restart: (0.0, self._every_s), self._probe: (0.0, self._probe_s)}
        due[self._take_look] = (0.0, self._look_s)
        while (at_s := time.monotonic() - since_s) < for_s:
            for do, (due_s, every_s) in due.items():
                if at_s >= due_s:
                    due[do] = (max(due_s + every_s, at_s), every_s)
                    do(fleet, at_s)
            if fleet.has_ended(max(min(at for at, _ in due.values()) - (time.monotonic() - since_s), 0.0)):
                return time.monotonic() - since_s
        return for_s

    def _restart(self, fleet: "LiveFleet", _: float) -> None:
        target, after_s = robot_name(next(self._targets)), 0.5 * self._every_s * self._speed
        with contextlib.suppress(UsageError):  # it is over: `_go_on` sees that
            request_fault(fleet.out, FaultRequest(rule=Restart(target=target, after_s=after_s)))
            self._restarts += 1

    def _probe(self, fleet: "LiveFleet", at_s: float) -> None:
        from clew.bench.soak import Probe
        from clew.fleet.prepare import probe
        from protocol.network.session import read_session

        began_s, took_s = time.monotonic(), None
        with contextlib.suppress(UsageError, OSError):
            probe(read_session(fleet.private / f"{WORLD}.json"))
            took_s = time.monotonic() - began_s
        self._probes.append(Probe(at_s=at_s, took_s=took_s))

    def _take_look(self, fleet: "LiveFleet", at_s: float) -> None:
        from clew.bench.soak import PARTS, Look
        from clew.bench.usage import processes, usage_of

        found = processes(fleet.processes)
        used = {part: usage for part in PARTS if (usage := usage_of(part, found)) is not None}
        with contextlib.suppress(OSError):  # it is over
            self._looks.append(Look(at_s=at_s, used=used, sessions=fleet.sessions))

    def _missing(self, fleet: "LiveFleet") -> int:
        from clew.bench.usage import processes

        return self._robots - sum(each.part == "robot" for each in processes(fleet.processes))
