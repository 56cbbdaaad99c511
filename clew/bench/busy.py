"""What becomes of live fleets on a machine that other processes keep busy; from their verdicts. Pure.

Rule 1: nobody kills a robot here, so every death in a verdict is false.
"""

from collections.abc import Sequence

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from world.judge.verdict import Verdict


class BusyRun(Struct, frozen=True, kw_only=True):
    """One run."""

    reason: str
    """As in the verdict; without one, what the launcher said last."""
    robots: int = 0
    robots_arrived: int = 0
    false_deaths: int = 0
    heals: int = 0
    violations: int = 0
    sim_s: float = 0.0
    wall_s: float = 0.0
    """From the first odometry on."""
    launcher_s: float
    """From the launcher's start to its end."""
    speed_reached: float | None = None

    @property
    def ok(self) -> bool:
        """Whether all arrived, nobody was held for dead, and no promise was broken."""
        return 0 < self.robots == self.robots_arrived and self.false_deaths == self.violations == 0


class BusyFigures(Struct, frozen=True, kw_only=True):
    """All runs together."""

    busy: int
    """Processes beside the fleet that compute all the time."""
    cores: int
    load: float
    """The machine's load average at the end."""
    runs: tuple[BusyRun, ...]

    @property
    def ok(self) -> bool:
        """Whether every run was well."""
        return len(self.runs) > 0 and all(run.ok for run in self.runs)


def busy_run(verdict: Verdict | None, said: Sequence[str], *, launcher_s: float) -> BusyRun:
    """What became of one run."""
    if verdict is None:
        return BusyRun(reason=said[-1] if said else "it said nothing", launcher_s=launcher_s)
    return BusyRun(
        reason=verdict.reason,
        robots=verdict.robots,
        robots_arrived=verdict.robots_arrived,
        false_deaths=len(verdict.deaths),
        heals=len(verdict.heals),
        violations=verdict.violations,
        sim_s=verdict.sim_s,
        wall_s=verdict.wall_s,
        launcher_s=launcher_s,
        speed_reached=verdict.speed_reached,
    )


def common(found: BusyFigures) -> list[Figure]:
    """The figures of all runs; a run without a verdict has reached no speed."""
    runs = found.runs
    return [
        figure("held for dead", "robots", [run.false_deaths for run in runs], aim=Aim(at_most=0.0)),
        figure(
            "not arrived", "robots", [run.robots - run.robots_arrived for run in runs], aim=Aim(at_most=0.0)
        ),
        figure("speed reached", "times real time", [run.speed_reached or 0.0 for run in runs]),
        figure("launcher's start to end", "s", [run.launcher_s for run in runs]),
    ]
