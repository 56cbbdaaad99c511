"""What it costs to run a fleet of many processes, and how that grows with the fleet. Pure.

Rule 1: the clock begins when the launcher is started. A fleet is ready when the world places the bodies, for
        then all robots are there; it has formed when the last robot has joined the strand. Both are told by
        the clock of the machine, in the timeline.
Rule 2: a fleet that has formed is stopped for a while and then released (`clew fault stop`): its processes
        say and hear the same as before, and no body moves. Then it drives to its goal.
Rule 3: processor time is per robot and simulated second: a machine that is busy otherwise, or a clock that
        runs slower, does not change it.
"""

from collections.abc import Mapping
from typing import Any

import msgspec
from msgspec import Struct

from clew.bench.forming import QUEUE, SPACING_M
from clew.bench.usage import Usage
from clew.fields.scatter import scatter
from clew.fields.shapes import circle
from world.chance import stream
from world.geometry.shapes import Circle
from world.judge.verdict import Late, Verdict
from world.scenario.scenario import Scenario

FLEETS = (5, 50, 200, 500, 1000)
NTP64_PER_S = 2**32
HEIGHT_M = 3.0
GROUND_M = 3.0  # before the first robot, with posts
DENSITY = 0.04
WIDTH_M = 0.7  # the posts keep this much room for robots of 0.2 m
PSS_MB_MAX, READY_S_MAX, FORMED_S_MAX, LATE_S_MAX = 5.0, 5.0, 20.0, 0.05


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


class _Head(Struct):
    t_s: float
    hlc: str = ""
    kind: str = ""

    @property
    def wall_s(self) -> float:
        return int(self.hlc.partition("/")[0] or 0) / NTP64_PER_S


class Progress:
    """How far a run has come, from the bytes of its timeline as they are written."""

    def __init__(self, robots: int) -> None:
        self._robots = robots
        self._rest = b""
        self.now_s = 0.0
        """Simulated time of the newest entry."""
        self.ready_at_s: float | None = None
        """When the bodies were placed [s since 1970]."""
        self.formed_at_s: float | None = None
        """When the last robot joined the first strand [s since 1970]."""
        self.formed_s: float | None = None
        """The same in simulated time."""
        self.is_over = False
        """Whether robots have begun to tell their last counts."""
        self.joined = 0
        """How many robots have joined, in all strands together."""

    def read(self, piece: bytes) -> None:
        """Take in more of the timeline."""
        *lines, self._rest = (self._rest + piece).split(b"\n")
        for line in lines:
            if b'"kind":"strand.joined"' in line:
                self._join(msgspec.json.decode(line, type=_Head))
            elif b'"kind":"robot.settled"' in line:
                self.is_over = True
            elif self.ready_at_s is None and b'"kind":"pose.sampled"' in line:
                self.ready_at_s = msgspec.json.decode(line, type=_Head).wall_s
        if lines:
            self.now_s = max(self.now_s, msgspec.json.decode(lines[-1], type=_Head).t_s)

    def _join(self, entry: _Head) -> None:
        self.joined += 1
        if self.joined == self._robots:
            self.formed_at_s, self.formed_s = entry.wall_s, entry.t_s


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
    speed: float
    """That was asked for."""
    ok: bool
    """The verdict."""
    reason: str
    """As in the verdict; without one, what the launcher said last."""
    ready_s: float | None
    """From the launcher's start [wall s]."""
    formed_s: float | None
    """Likewise."""
    formed_sim_s: float | None
    """The same in simulated time."""
    standing: Spell | None
    driving: Spell | None
    speed_reached: float | None
    ticks_late: Late | None
    deaths: int
    """Nobody kills a robot here: each is one that was held for dead."""
    sim_s: float
    wall_s: float
    messages_per_s: float
    """Of wall-clock time."""
    load: tuple[float, float]
    """The machine's load average, before and after."""

    @property
    def misses(self) -> list[str]:
        """The aims that it has not reached."""
        pss_mb = None if self.driving is None or self.driving.robot is None else self.driving.robot.pss_mb
        late_s = None if self.ticks_late is None else self.ticks_late.p99_s
        aims = {
            f"ready within {READY_S_MAX:g} s": _within(self.ready_s, READY_S_MAX),
            f"formed within {FORMED_S_MAX:g} s": _within(self.formed_s, FORMED_S_MAX),
            f"at most {PSS_MB_MAX:g} MB for a robot": _within(pss_mb, PSS_MB_MAX),
            f"99 % of ticks less than {LATE_S_MAX:g} s late": _within(late_s, LATE_S_MAX),
            "verdict ok": self.ok,
        }
        return [aim for aim, reached in aims.items() if not reached]


def _within(value: float | None, most: float) -> bool:
    return value is not None and value <= most


def scale_run(
    verdict: Verdict | None,
    progress: Progress,
    *,
    robots: int,
    speed: float,
    began_s: float,
    said: str,
    standing: Spell | None,
    driving: Spell | None,
    load: tuple[float, float],
) -> ScaleRun:
    """What became of one fleet; `began_s` is when its launcher was started [s since 1970]."""

    def since(at_s: float | None) -> float | None:
        return None if at_s is None else at_s - began_s

    wall_s = 0.0 if verdict is None else verdict.wall_s
    return ScaleRun(
        robots=robots,
        speed=speed,
        ok=verdict is not None and verdict.ok,
        reason=said if verdict is None else verdict.reason,
        ready_s=since(progress.ready_at_s),
        formed_s=since(progress.formed_at_s),
        formed_sim_s=progress.formed_s,
        standing=standing,
        driving=driving,
        speed_reached=None if verdict is None else verdict.speed_reached,
        ticks_late=None if verdict is None else verdict.ticks_late,
        deaths=0 if verdict is None else len(verdict.deaths),
        sim_s=0.0 if verdict is None else verdict.sim_s,
        wall_s=wall_s,
        messages_per_s=0.0 if verdict is None or wall_s <= 0.0 else verdict.messages.sent / wall_s,
        load=load,
    )
