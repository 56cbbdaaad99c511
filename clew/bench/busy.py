"""What becomes of live fleets on a machine that other processes keep busy; from their verdicts. Pure.

Rule 1: nobody kills a robot here, so every death in a verdict is false.
"""

import math
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


def busy_run(verdict: Verdict | None, said: str, *, launcher_s: float) -> BusyRun:
    """What became of one run; `said`: the launcher's last line on stderr."""
    if verdict is None:
        return BusyRun(reason=said, launcher_s=launcher_s)
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


def figures(runs: Sequence[BusyRun]) -> list[Figure]:
    """The figures of all runs; of a run without a verdict nobody has arrived, and it has reached no speed."""
    none = Aim(at_most=0.0, each=True)
    away = [run.robots - run.robots_arrived if run.robots else math.inf for run in runs]
    return [
        figure("declared dead", "robots", [run.false_deaths for run in runs], aim=none),
        figure("not arrived", "robots", away, aim=none),
        figure("promises broken", "", [run.violations for run in runs], aim=none),
        figure("speed reached", "times real time", [run.speed_reached or 0.0 for run in runs]),
        figure("launcher's start to end", "s", [run.launcher_s for run in runs]),
    ]
