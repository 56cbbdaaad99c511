"""How soon a strand detects that its leader is lost, and has a new one; from timelines of live fleets. Pure.

Rule 1: times are differences of `hlc`, the wall clock of one machine. Simulated time would look better
        when the world is late.
Rule 2: the cause is the entry that the world records just before the fault. Detection is the first
        `link.broken` that names the leader. Succession is the time from detection to `leader.succeeded`. The
        strand drives again when the body that leads has accepted the first order in its strand: the next
        leader's, or, where the strand turns round first, the body's at its other end.
Rule 3: each run has the fault at another moment, so that no single phase of a period is measured.
"""

import math
from collections.abc import Iterable, Sequence
from enum import StrEnum

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from clew.percentiles import percentile
from clew.rehearsal.logbook import NTP64_PER_S
from protocol.faults.plan import Plan
from protocol.faults.rules import Freeze, Kill
from protocol.keys import robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    LeaderSucceeded,
    LinkBroken,
    OrderAccepted,
    StrandFormed,
    StrandHealed,
)

SUCCESSION_S_MAX = 1.0  # from detection, for both faults
ORDERED_S_MAX = 0.8  # of the median, where the leader is killed
FIRST_S, APART_S = 2.5, 0.13  # times of the faults: the fleet drives, and no multiple of a heartbeat apart


class LeaderFault(StrEnum):
    """What happens to the leader."""

    KILL = "kill"
    FREEZE = "freeze"

    @property
    def ordered_s_max(self) -> float | None:
        """Bound of the median time until the next leader's first order; None: none is asked for."""
        return ORDERED_S_MAX if self is LeaderFault.KILL else None

    @property
    def detection_s_max(self) -> float:
        """Bound of the detection: a token goes at once (kill), or after its lease of 1 s (freeze)."""
        return 0.5 if self is LeaderFault.KILL else 1.5

    def plan(self, run: int) -> Plan:
        """The fault plan of a run, by its number."""
        from_s = round(FIRST_S + APART_S * run, 3)
        kind = Kill if self is LeaderFault.KILL else Freeze
        return Plan(name=f"leader-{self}", rules=(kind(target="leader", from_s=from_s),))


class Healing(Struct, frozen=True, kw_only=True):
    """How long one strand took [wall-clock s]; None: the event never came."""

    cause_s: float
    """Simulated time of the fault."""
    detection_s: float | None = None
    succession_s: float | None = None
    ordered_s: float | None = None
    """From the cause until the first order of a leader in the strand without the lost one."""
    healed_s: float | None = None
    """From the cause until the next leader said that the strand drives again."""


class Times(Struct, frozen=True, kw_only=True):
    """Percentiles of a time over the runs; `ok`: the one that has the bound is within it."""

    p50_s: float
    p99_s: float
    bound_s: float | None
    ok: bool


class HealingFigures(Struct, frozen=True, kw_only=True):
    """Figures of the runs with one fault."""

    fault: LeaderFault
    runs: int
    never: int
    """Runs in which an event never came."""
    detection: Times | None
    succession: Times | None
    ordered: Times | None
    """Its bound is of the median."""
    healed: Times | None
    loads: tuple[float, ...]
    """The machine's load average after each run."""
    each: tuple[Healing | None, ...]
    """None: the fault never happened."""

    @property
    def ok(self) -> bool:
        """Whether every run was within the bounds."""
        times = (self.detection, self.succession, self.ordered)
        return self.never == 0 and all(each is not None and each.ok for each in times)


def healing_in(lines: Iterable[tuple[str, Entry]]) -> Healing | None:
    """How long the strand took; None where no process fault happened."""
    entries = sorted(lines, key=lambda line: wall_s(line[1]))
    injection = next((entry for _, entry in entries if _is_process_fault(entry)), None)
    if injection is None:
        return None
    assert isinstance(injection.record, FaultInjected), "found by its type"
    robot, cause_s = robot_number(injection.record.process or ""), wall_s(injection)
    broken_s: float | None = None
    succeeded_s: float | None = None
    ordered_s: float | None = None
    healed_s: float | None = None
    leads: tuple[int, int] | None = None
    for _, entry in entries:
        at_s = wall_s(entry) - cause_s
        match entry.record:
            case LinkBroken(neighbour=neighbour) if neighbour == robot and broken_s is None and at_s > 0.0:
                broken_s = at_s
            case LeaderSucceeded(before=before) if before == robot and succeeded_s is None:
                succeeded_s = at_s
            case StrandFormed(epoch=epoch, order=(leader, *_)) if broken_s is not None:
                leads = leader, epoch
            case OrderAccepted(target=target, epoch=epoch, robot=body) if ordered_s is None:
                ordered_s = at_s if target is not None and (body, epoch) == leads else None
            case StrandHealed() if succeeded_s is not None and healed_s is None:
                healed_s = at_s
            case _:
                pass
    return Healing(
        cause_s=injection.t_s,
        detection_s=broken_s,
        succession_s=None if broken_s is None or succeeded_s is None else succeeded_s - broken_s,
        ordered_s=ordered_s,
        healed_s=healed_s,
    )


def figures_of(
    fault: LeaderFault, measured: Sequence[Healing | None], loads: Sequence[float]
) -> HealingFigures:
    """Figures of the runs."""
    known = [each for each in measured if each is not None]
    whole = [
        each
        for each in known
        if None not in (each.detection_s, each.succession_s, each.ordered_s, each.healed_s)
    ]
    return HealingFigures(
        fault=fault,
        runs=len(measured),
        never=len(measured) - len(whole),
        detection=_times([each.detection_s for each in known], fault.detection_s_max),
        succession=_times([each.succession_s for each in known], SUCCESSION_S_MAX),
        ordered=_times([each.ordered_s for each in known], fault.ordered_s_max, judged=50),
        healed=_times([each.healed_s for each in known], None),
        loads=tuple(loads),
        each=tuple(measured),
    )


def common(row: HealingFigures) -> list[Figure]:
    """The figures of the runs with one fault; a run without a fault is a run in which nothing ever came."""
    fault, each = row.fault, [one or Healing(cause_s=0.0) for one in row.each]
    asked = (
        ("fault to detection", [one.detection_s for one in each], fault.detection_s_max),
        ("detection to succession", [one.succession_s for one in each], SUCCESSION_S_MAX),
        ("fault to the next leader's first order", [one.ordered_s for one in each], fault.ordered_s_max),
        ("fault to healing", [one.healed_s for one in each], None),
    )
    return [
        figure(
            f"{fault}: {name}",
            "s",
            [math.inf if time_s is None else time_s for time_s in times_s],
            aim=None if bound_s is None else Aim(at_most=bound_s),
        )
        for name, times_s, bound_s in asked
    ]


def wall_s(entry: Entry) -> float:
    """When an entry was made [s since 1970; its source's clock]."""
    ticks, _, _ = entry.hlc.partition("/")
    return int(ticks) / NTP64_PER_S


def _is_process_fault(entry: Entry) -> bool:
    return isinstance(entry.record, FaultInjected) and entry.record.process is not None


def _times(times_s: Sequence[float | None], bound_s: float | None, *, judged: int = 99) -> Times | None:
    """`judged`: the percentile that has the bound."""
    known_s = [each_s for each_s in times_s if each_s is not None]
    if not known_s:
        return None
    p50_s, p99_s, judged_s = (percentile(known_s, percent) for percent in (50, 99, judged))
    return Times(p50_s=p50_s, p99_s=p99_s, bound_s=bound_s, ok=bound_s is None or judged_s <= bound_s)
