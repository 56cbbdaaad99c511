"""How soon a live strand sees that its leader is gone, and has another: from real fleets' timelines. Pure.

Rule 1: times are differences of `hlc`, the wall clock of one machine: simulated time would be kinder where
        the world is late.
Rule 2: the cause is the entry that the world records right before it strikes; detection is the first
        `link.broken` that names the leader; succession is from there to `leader.succeeded` in its place.
Rule 3: each run strikes at another moment of the crossing, so that no one phase of any period is measured.
"""

from collections.abc import Iterable, Sequence
from enum import StrEnum

from msgspec import Struct

from clew.percentiles import percentile
from clew.rehearsal.logbook import NTP64_PER_S
from protocol.faults.plan import Plan
from protocol.faults.rules import Freeze, Kill
from protocol.keys import robot_number
from protocol.timeline import Entry, FaultInjected, LeaderSucceeded, LinkBroken, StrandHealed

SUCCESSION_S_MAX = 1.0  # from detection, whatever the blow
FIRST_S, APART_S = 2.5, 0.13  # when leaders are struck: under way, and no multiple of any heartbeat apart


class LeaderBlow(StrEnum):
    """What is done to the leader."""

    KILL = "kill"
    FREEZE = "freeze"

    @property
    def detection_s_max(self) -> float:
        """The longest that it may take to be seen: a token goes at once, or after its lease of 1 s."""
        return 0.5 if self is LeaderBlow.KILL else 1.5

    def plan(self, run: int) -> Plan:
        """The plan of the so-many-th run."""
        from_s = round(FIRST_S + APART_S * run, 3)
        kind = Kill if self is LeaderBlow.KILL else Freeze
        return Plan(name=f"leader-{self}", rules=(kind(target="leader", from_s=from_s),))


class Healing(Struct, frozen=True, kw_only=True):
    """How long one strand took [wall s]; None: that never came."""

    cause_s: float
    """Simulated."""
    detection_s: float | None = None
    succession_s: float | None = None
    healed_s: float | None = None
    """From the cause on until the next leader knew all to be with it."""


class Times(Struct, frozen=True, kw_only=True):
    """How a time is spread over the runs; of twenty the 99th percentile is the longest."""

    p50_s: float
    p99_s: float
    bound_s: float | None
    ok: bool


class HealingFigures(Struct, frozen=True, kw_only=True):
    """What the runs with one blow come to."""

    blow: LeaderBlow
    runs: int
    never: int
    """Runs in which something of it never came."""
    detection: Times | None
    succession: Times | None
    healed: Times | None
    loads: tuple[float, ...]
    """The machine's, of the last minute, after each run."""
    each: tuple[Healing | None, ...]
    """None: the leader was not struck."""

    @property
    def ok(self) -> bool:
        """Whether every run kept to the bounds."""
        times = (self.detection, self.succession)
        return self.never == 0 and all(each is not None and each.ok for each in times)


def healing_in(lines: Iterable[tuple[str, Entry]]) -> Healing | None:
    """How long the strand took whose leader was struck; None where none was."""
    entries = sorted(lines, key=lambda line: wall_s(line[1]))
    struck = next((entry for _, entry in entries if _is_stroke(entry)), None)
    if struck is None:
        return None
    assert isinstance(struck.record, FaultInjected), "of processes"
    robot, cause_s = robot_number(struck.record.process or ""), wall_s(struck)
    broken_s: float | None = None
    succeeded_s: float | None = None
    healed_s: float | None = None
    for _, entry in entries:
        at_s = wall_s(entry) - cause_s
        match entry.record:
            case LinkBroken(neighbour=neighbour) if neighbour == robot and broken_s is None and at_s > 0.0:
                broken_s = at_s
            case LeaderSucceeded(before=before) if before == robot and succeeded_s is None:
                succeeded_s = at_s
            case StrandHealed() if succeeded_s is not None and healed_s is None:
                healed_s = at_s
            case _:
                pass
    return Healing(
        cause_s=struck.t_s,
        detection_s=broken_s,
        succession_s=None if broken_s is None or succeeded_s is None else succeeded_s - broken_s,
        healed_s=healed_s,
    )


def figures_of(
    blow: LeaderBlow, measured: Sequence[Healing | None], loads: Sequence[float]
) -> HealingFigures:
    """What the runs come to."""
    known = [each for each in measured if each is not None]
    whole = [each for each in known if None not in (each.detection_s, each.succession_s, each.healed_s)]
    return HealingFigures(
        blow=blow,
        runs=len(measured),
        never=len(measured) - len(whole),
        detection=_times([each.detection_s for each in known], blow.detection_s_max),
        succession=_times([each.succession_s for each in known], SUCCESSION_S_MAX),
        healed=_times([each.healed_s for each in known], None),
        loads=tuple(loads),
        each=tuple(measured),
    )


def wall_s(entry: Entry) -> float:
    """When an entry was made, by its source's clock, since 1970."""
    ticks, _, _ = entry.hlc.partition("/")
    return int(ticks) / NTP64_PER_S


def _is_stroke(entry: Entry) -> bool:
    return isinstance(entry.record, FaultInjected) and entry.record.process is not None


def _times(times_s: Sequence[float | None], bound_s: float | None) -> Times | None:
    known_s = [each_s for each_s in times_s if each_s is not None]
    if not known_s:
        return None
    p50_s, p99_s = (percentile(known_s, percent) for percent in (50, 99))
    return Times(p50_s=p50_s, p99_s=p99_s, bound_s=bound_s, ok=bound_s is None or p99_s <= bound_s)
