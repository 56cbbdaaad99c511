"""How soon a strand detects that its leader is lost, and has a new one; from timelines of live fleets. Pure.

Rule 1: times are differences of `hlc`, the wall clock of one machine. Simulated time would look better
        when the world is late.
Rule 2: the cause is the entry that the world records just before the fault. Detection is the first
        `link.broken` that names the leader. Succession is the time from detection to `leader.succeeded`. The
        strand drives again when the body that leads has accepted the first order in its strand: the next
        leader's, or, where the strand turns round first, the body's at its other end.
Rule 3: each run has the fault at another moment, so that no single phase of a period is measured.
"""

from collections.abc import Iterable
from enum import StrEnum

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
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
    def ordered_aim(self) -> Aim:
        """Of the time until the next leader's first order."""
        return Aim(at_most=ORDERED_S_MAX) if self is LeaderFault.KILL else Aim(each=True)

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


class HealingRuns(Struct, frozen=True, kw_only=True):
    """The runs with one fault."""

    fault: LeaderFault
    loads: tuple[float, ...]
    """The machine's load average after each run."""
    each: tuple[Healing | None, ...]
    """None: the fault never happened."""


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


def figures(runs: HealingRuns) -> list[Figure]:
    """The figures of the runs with one fault; a run without a fault is a run in which nothing ever came."""
    fault, each = runs.fault, [one or Healing(cause_s=0.0) for one in runs.each]
    detected, succeeded = (
        Aim(at_most=most_s, each=True) for most_s in (fault.detection_s_max, SUCCESSION_S_MAX)
    )
    times = (
        ("fault to detection", [one.detection_s for one in each], detected),
        ("detection to succession", [one.succession_s for one in each], succeeded),
        ("fault to the next leader's first order", [one.ordered_s for one in each], fault.ordered_aim),
        ("fault to healing", [one.healed_s for one in each], Aim(each=True)),
    )
    return [figure(f"{fault}: {name}", "s", times_s, aim=aim) for name, times_s, aim in times]


def wall_s(entry: Entry) -> float:
    """When an entry was made [s since 1970; its source's clock]."""
    ticks, _, _ = entry.hlc.partition("/")
    return int(ticks) / NTP64_PER_S


def _is_process_fault(entry: Entry) -> bool:
    return isinstance(entry.record, FaultInjected) and entry.record.process is not None
