"""What grows in a fleet whose robots are killed and started again, for a long time. Pure.

Rule 1: a fleet is looked at from the moment in which it has formed. Growth is the median of the last third of
        the looks less that of the second third: the first third is a warm-up.
Rule 2: growth has a bound. A restarted robot shares other pages than the one before, so memory has some room.
Rule 3: a probe is a new session at the fleet's router, beside all others. Each must get in.
"""

import math
from collections.abc import Callable, Iterator

import msgspec
from msgspec import Struct

from clew.bench.forming import queue
from clew.bench.result import Aim, Figure, figure
from clew.bench.usage import Usage
from clew.percentiles import percentile
from world.chance import stream
from world.scenario.scenario import Scenario

PARTS = ("robot", "world", "router", "host", "launcher")
GROWTH_MAX, GROWTH_MB_MIN = 0.1, 2.0  # of the memory of a part, and at least so much
FILES_GROWTH_MAX = SESSIONS_GROWTH_MAX = 2.0  # a robot that is just down, a probe
ADMISSION_S_MAX = 1.0
SPARE_S = 120.0  # of the scenario's time, for the start and the end


class Look(Struct, frozen=True, kw_only=True):
    """The fleet at one moment."""

    at_s: float
    """Since it had formed."""
    used: dict[str, Usage]
    """By part."""
    sessions: int
    """At the router."""


class Probe(Struct, frozen=True, kw_only=True):
    """One try to get in."""

    at_s: float
    took_s: float | None
    """None: it was refused."""


class Soak(Struct, frozen=True, kw_only=True):
    """One fleet."""

    robots: int
    asked_s: float
    """For how long it was to be soaked."""
    soaked_s: float
    """For how long it was."""
    restarts: int
    looks: tuple[Look, ...]
    probes: tuple[Probe, ...]
    missing: int
    """Robots without a process at the end."""
    violations: int | None
    """None: there is no verdict."""
    said: str
    """The reason of the verdict; without one, what the launcher said last."""
    load: tuple[float, float]
    """The machine's load average, before and after."""


def endless_queue(robots: int, *, wall_s: float, speed: float) -> Scenario:
    """Robots in a straight queue on open ground, whose goal is too far away to be reached in this time."""
    scenario = queue(robots)
    raw = msgspec.to_builtins(scenario)
    sim_s = wall_s * speed + SPARE_S
    far_m = scenario.drive.speed_mps * sim_s
    x_m, y_m = raw["goal"]["at_m"]
    raw["goal"]["at_m"] = [x_m + far_m, y_m]
    raw["bounds"]["x_m_max"] += far_m
    raw["time"]["time_s_max"] = sim_s
    return msgspec.convert(raw | {"name": "endless queue"}, Scenario)


def targets(robots: int) -> Iterator[int]:
    """The robots to kill, one after the other: all in turn, in an order that is drawn anew."""
    drawn = stream(robots, "soak/targets")
    while True:
        yield from (int(robot) + 1 for robot in drawn.permutation(robots))


def figures(soak: Soak) -> list[Figure]:
    """The figures of a soak."""
    took_s = [math.inf if each.took_s is None else each.took_s for each in soak.probes] or [math.inf]
    found = [
        figure("time soaked", "s", [soak.soaked_s], aim=Aim(at_least=soak.asked_s)),
        figure("robots killed and started again", "", [soak.restarts]),
        figure("robots without a process at the end", "", [soak.missing], aim=Aim(at_most=0.0)),
        figure("promises broken", "", [soak.violations], aim=Aim(at_most=0.0)),
        figure("probes", "", [len(soak.probes)]),
        figure("probes refused", "", [sum(map(math.isinf, took_s))], aim=Aim(at_most=0.0)),
        figure("admission, median", "s", [percentile(took_s, 50)]),
        figure("admission, longest", "s", [max(took_s)], aim=Aim(at_most=ADMISSION_S_MAX)),
    ]
    for part in PARTS:
        found += _growth(f"memory of a {part}", "MB", soak, _of(part, lambda used: used.pss_mb), _room_mb)
        found += _growth(
            f"descriptors of a {part}",
            "",
            soak,
            _of(part, lambda used: used.files),
            lambda _: FILES_GROWTH_MAX,
        )
    return found + _growth(
        "sessions at the router", "", soak, lambda look: float(look.sessions), lambda _: SESSIONS_GROWTH_MAX
    )


def _room_mb(before_mb: float) -> float:
    """Rule 2."""
    return max(GROWTH_MAX * before_mb, GROWTH_MB_MIN)


def _of(part: str, value: Callable[[Usage], float]) -> Callable[[Look], float]:
    return lambda look: value(look.used[part]) if part in look.used else math.inf


def _growth(
    name: str, unit: str, soak: Soak, value: Callable[[Look], float], room: Callable[[float], float]
) -> list[Figure]:
    """Rule 1: what was there in the second third, and how much more in the last."""
    values = [value(look) for look in soak.looks]
    third = len(values) // 3
    if third == 0:
        return [figure(f"{name}, growth", unit, [math.inf], aim=Aim(at_most=0.0))]
    before, after = percentile(values[third : 2 * third], 50), percentile(values[2 * third :], 50)
    grown = after - before if math.isfinite(before) else math.inf
    return [
        figure(name, unit, [before]),
        figure(f"{name}, growth", unit, [grown], aim=Aim(at_most=round(room(before), 1))),
    ]
