"""What it costs to run a fleet of many processes, and how that grows with the fleet. Pure.

Rule 1: the clock begins when the launcher is started. A fleet is ready when the world places the bodies, for
        then all robots are there; it has formed when the last robot has joined the strand (`progress.py`).
Rule 2: a fleet that has formed is stopped for a while and then released (`clew fault stop`): its processes
        say and hear the same as before, and no body moves. Then it drives to its goal.
Rule 3: processor time is of all processes, per robot and simulated second: a machine that is busy otherwise,
        or a clock that runs slower, does not change it.
Rule 4: runs of fleets of one size are repeats.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import msgspec
from msgspec import Struct

from clew.bench.forming import QUEUE, SPACING_M
from clew.bench.progress import Together
from clew.bench.result import Aim, Figure, figure
from clew.bench.usage import Usage
from clew.fields.scatter import scatter
from clew.fields.shapes import circle
from world.chance import stream
from world.geometry.shapes import Circle
from world.judge.verdict import Late, Verdict
from world.scenario.fleets import SharedGround
from world.scenario.scenario import Scenario

FLEETS = (5, 50, 200, 500, 1000)
HEIGHT_M = 3.0
GROUND_M = 3.0  # before the first robot, with posts
DENSITY = 0.04
WIDTH_M = 0.7  # the posts keep this much room for robots of 0.2 m
PSS_MB_MAX, READY_S_MAX, FORMED_S_MAX, LATE_MS_MAX = 5.0, 5.0, 20.0, 50.0
FEW_ROBOTS, GROWTH_MAX = 50, 1.3  # a robot of a larger fleet costs at most so many times as one of this
FEW = f"{FEW_ROBOTS} robots"


def queue_before_posts(robots: int, *, seed: int) -> Scenario:
    """Robots in a straight queue, before open ground with some posts, and the goal behind that."""
    first_m, middle_m = SPACING_M * robots + 1.0, HEIGHT_M / 2.0
    ground_m = first_m + 1.0
    posts = scatter(
        [circle],
        stream(seed, "scale/posts"),
        size_m=(GROUND_M, HEIGHT_M),
        density=DENSITY,
        least_width_m=WIDTH_M,
        unit_m=QUEUE["fleet"]["robot_radius_m"],
    )
    raw: dict[str, Any] = {
        **QUEUE,
        "name": "queue before posts",
        "fleet": {**QUEUE["fleet"], "robots": robots, "start": [first_m, middle_m, 0.0]},
        "goal": {"at_m": [ground_m + GROUND_M + 0.5, middle_m], "tolerance_m": 0.15},
        "bounds": {
            "x_m_min": 0.0,
            "y_m_min": 0.0,
            "x_m_max": ground_m + GROUND_M + 1.5,
            "y_m_max": HEIGHT_M,
        },
        "obstacle": [
            {
                "shape": "circle",
                "centre_m": [round(each.centre_m[0] + ground_m, 3), each.centre_m[1]],
                "radius_m": each.radius_m,
            }
            for each in posts
            if isinstance(each, Circle)
        ],
    }
    return msgspec.convert(raw, Scenario)


def strands_before_posts(robots: int, strands: int, *, seed: int) -> SharedGround:
    """So many robots in all, in queues beside each other: each is a strand, with posts before it.

    The ground has no bounds: leaders would plan on all of it.
    """
    queues = [queue_before_posts(robots // strands, seed=seed + lane) for lane in range(strands)]
    raws: list[dict[str, Any]] = [
        _beside(msgspec.to_builtins(each), lane) for lane, each in enumerate(queues)
    ]
    fleets = [
        {**raw["fleet"], "goal": raw["goal"], "name": f"s{lane}"} for lane, raw in enumerate(raws, start=1)
    ]
    shared = {key: raws[0][key] for key in ("law", "sensor", "drive", "time")}
    return msgspec.convert(
        shared
        | {
            "name": "queues before posts",
            "fleet": fleets,
            "obstacle": [obstacle for raw in raws for obstacle in raw["obstacle"]],
        },
        SharedGround,
    )


def _beside(raw: dict[str, Any], lane: int) -> dict[str, Any]:
    """The queue, moved to its place beside the others."""

    def moved(point: Sequence[float]) -> list[float]:
        x_m, y_m, *heading = point
        return [x_m, y_m + lane * HEIGHT_M, *heading]

    return raw | {
        "fleet": raw["fleet"] | {"start": moved(raw["fleet"]["start"])},
        "goal": raw["goal"] | {"at_m": moved(raw["goal"]["at_m"])},
        "obstacle": [each | {"centre_m": moved(each["centre_m"])} for each in raw["obstacle"]],
    }


def ground_of(robots: int, strands: int, *, seed: int) -> Scenario | SharedGround:
    """The scenario for so many robots in so many strands."""
    if strands == 1:
        return queue_before_posts(robots, seed=seed)
    return strands_before_posts(robots, strands, seed=seed)


Doing = Literal["standing", "driving"]


class Spell(Struct, frozen=True, kw_only=True):
    """A time in which a fleet stood or drove."""

    sim_s: float
    wall_s: float
    cpu_ms: dict[str, float]
    """Of each part: processor time per robot and simulated second."""
    robot: Usage | None
    """At its end."""
    world: Usage | None
    router: Usage | None

    @property
    def cpu_ms_in_all(self) -> float:
        """Of all parts together."""
        return sum(self.cpu_ms.values())


def spell(
    spent_s: Mapping[str, float],
    *,
    robots: int,
    sim_s: float,
    wall_s: float,
    used: Mapping[str, Usage | None],
) -> Spell:
    """What a fleet has used in a time in which the simulated clock ran for so long."""
    per = 1000.0 / (robots * sim_s) if sim_s > 0.0 else 0.0
    return Spell(
        sim_s=sim_s,
        wall_s=wall_s,
        cpu_ms={part: each_s * per for part, each_s in sorted(spent_s.items())},
        robot=used.get("robot"),
        world=used.get("world"),
        router=used.get("router"),
    )


class ScaleRun(Struct, frozen=True, kw_only=True):
    """One fleet."""

    robots: int
    strands: int = 1
    """Among which they are divided."""
    speed: float
    """That was asked for."""
    ok: bool
    """The verdict, of each strand."""
    reason: str
    """As in the first verdict that is not ok; where one lacks, what the launcher said last."""
    ready_s: float | None
    """From the launcher's start [wall s]."""
    formed_s: float | None
    """Likewise."""
    formed_sim_s: float | None
    """The same in simulated time."""
    standing: Spell | None
    driving: Spell | None
    is_cut_short: bool = False
    """Whether it was told to end while it drove: then nothing is said of its arrival."""
    violations: int = 0
    speed_reached: float | None
    ticks_late: Late | None
    deaths: int
    """No fault kills a robot here: each of these was living when it was declared dead."""
    sim_s: float
    wall_s: float
    messages_per_s: float
    """Of wall-clock time."""
    load: tuple[float, float]
    """The machine's load average, before and after."""

    @property
    def is_good(self) -> bool:
        """Whether it has kept all its promises; arrival is one, if it was not told to end before."""
        return self.violations == 0 and self.deaths == 0 if self.is_cut_short else self.ok

    def pss_mb(self, how: Doing) -> float | None:
        """The memory of a robot at the end of that time."""
        spent = self._spent(how)
        return None if spent is None or spent.robot is None else spent.robot.pss_mb

    def cpu_ms(self, how: Doing) -> float | None:
        """The processor time of all parts together in that time."""
        spent = self._spent(how)
        return None if spent is None else spent.cpu_ms_in_all

    def _spent(self, how: Doing) -> Spell | None:
        return self.standing if how == "standing" else self.driving


def figures(runs: Sequence[ScaleRun]) -> list[Figure]:
    """The figures of all fleets, the smallest first; what never came is infinite."""
    sizes, few = sorted({_size(run) for run in runs}), [run for run in runs if _size(run) == (FEW_ROBOTS, 1)]
    return [each for size in sizes for each in _of_size([run for run in runs if _size(run) == size], few)]


def _size(run: ScaleRun) -> tuple[int, int]:
    return run.robots, run.strands


def _of_size(runs: Sequence[ScaleRun], few: Sequence[ScaleRun]) -> list[Figure]:
    """The figures of fleets of one size; what a robot costs is compared with fleets of few robots."""
    late = [run.ticks_late for run in runs]
    p50_ms = [None if each is None else 1000.0 * each.p50_s for each in late]
    p99_ms = [None if each is None else 1000.0 * each.p99_s for each in late]
    rows: list[tuple[str, str, list[float | None], float | None]] = [
        ("ready", "s", [run.ready_s for run in runs], READY_S_MAX),
        ("formed", "s", [run.formed_s for run in runs], FORMED_S_MAX),
        ("memory of a robot, standing", "MB", [run.pss_mb("standing") for run in runs], PSS_MB_MAX),
        ("memory of a robot, driving", "MB", [run.pss_mb("driving") for run in runs], PSS_MB_MAX),
        ("ticks late, median", "ms", p50_ms, None),
        ("ticks late, p99", "ms", p99_ms, LATE_MS_MAX),
        ("messages", "1/s", [run.messages_per_s for run in runs], None),
        ("speed reached", "times real time", [run.speed_reached for run in runs], None),
    ]
    robots, strands = _size(runs[0])
    fleet = f"{robots} robots" if strands == 1 else f"{robots} robots in {strands} strands"
    told = [
        figure(
            f"{fleet}: {name}",
            unit,
            values,
            aim=None if most is None else Aim(at_most=most),
        )
        for name, unit, values, most in rows
    ]
    is_compared = robots > FEW_ROBOTS and len(few) == len(runs)
    told[4:4] = [
        figure(
            f"{fleet}: CPU time for a robot, {how}",
            "ms/s",
            [run.cpu_ms(how) for run in runs],
            baselines={FEW: [run.cpu_ms(how) for run in few]} if is_compared else None,
            aim=Aim(of=FEW, at_most=GROWTH_MAX) if is_compared else None,
        )
        for how in ("standing", "driving")
    ]
    verdicts = [float(run.is_good) for run in runs]
    name = "no promise broken, nobody declared dead" if runs[0].is_cut_short else "verdict ok"
    return [*told, figure(f"{fleet}: {name}", "", verdicts, aim=Aim(at_least=1.0))]


def scale_run(
    verdicts: Sequence[Verdict],
    progress: Together,
    *,
    robots: int,
    strands: int = 1,
    contacts: int = 0,
    speed: float,
    began_s: float,
    said: str,
    standing: Spell | None,
    driving: Spell | None,
    is_cut_short: bool = False,
    load: tuple[float, float],
) -> ScaleRun:
    """What became of one fleet.

    Args:
        verdicts: of its strands, as far as they have one.
        progress: how far it came.
        robots: how many it has.
        strands: among which they are divided.
        contacts: of robots of two strands.
        speed: that was asked for.
        began_s: when its launcher was started [s since 1970].
        said: what the launcher said last.
        standing: what it used while it stood.
        driving: what it used while it drove.
        is_cut_short: whether it was told to end while it drove.
        load: the machine's load average, before and after.
    """

    def since(at_s: float | None) -> float | None:
        return None if at_s is None else at_s - began_s

    is_judged = len(verdicts) == strands
    failed = [each for each in verdicts if not each.ok]
    wall_s = max((each.wall_s for each in verdicts), default=0.0)
    speeds = [each.speed_reached for each in verdicts if each.speed_reached is not None]
    late = [each.ticks_late for each in verdicts if each.ticks_late is not None]
    return ScaleRun(
        robots=robots,
        strands=strands,
        speed=speed,
        ok=is_judged and not failed and contacts == 0,
        reason=(failed or verdicts)[0].reason if is_judged else said,
        ready_s=since(progress.ready_at_s),
        formed_s=since(progress.formed_at_s),
        formed_sim_s=progress.formed_s,
        standing=standing,
        driving=driving,
        is_cut_short=is_cut_short and is_judged,
        violations=contacts + sum(each.violations for each in verdicts),
        speed_reached=min(speeds, default=None),
        ticks_late=max(late, key=lambda each: each.p99_s, default=None),
        deaths=sum(len(each.deaths) for each in verdicts),
        sim_s=max((each.sim_s for each in verdicts), default=0.0),
        wall_s=wall_s,
        messages_per_s=sum(each.messages.sent for each in verdicts) / wall_s if wall_s > 0.0 else 0.0,
        load=load,
    )
