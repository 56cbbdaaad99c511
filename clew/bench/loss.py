"""How much longer a fleet takes when messages are lost: rehearsed with several seeds, and live. Pure.

Rule 1: there are two curves: loss of messages between robots, and loss of all messages, also those of bodies.
Rule 2: the time of a fleet that has not arrived when the scenario's time is up counts as infinite.
"""

from collections.abc import Sequence
from enum import StrEnum

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.rules import Drop, MessageKind
from world.judge.ending import Ending
from world.scenario.scenario import Scenario

RATES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9)
BOUNDS = {0.5: 1.10, 0.75: 1.5}
"""By rate of loss between robots: how many times as long a fleet may take. At all rates it must arrive."""


class Reach(StrEnum):
    """Which messages are lost."""

    LINKS = "links"
    ALL = "all"

    @property
    def kinds(self) -> tuple[MessageKind, ...]:
        """Kinds of messages, as in a fault plan; empty: all kinds."""
        return ("ahead", "behind", "report", "answer", "formation", "plea") if self is Reach.LINKS else ()


UNIT, WITHOUT = "simulated s", "without loss"
NAMES = {Reach.LINKS: "messages between robots", Reach.ALL: "all messages"}


class Crossing(Struct, frozen=True, kw_only=True):
    """One run."""

    seed: int
    time_s: float | None
    """Simulated time until all robots arrived; None: they did not."""
    violations: int
    load: float | None = None
    """The machine's load average, of a live run."""


class LossPoint(Struct, frozen=True, kw_only=True):
    """All runs with one rate of loss."""

    reach: Reach
    rate: float
    rehearsed: tuple[Crossing, ...]
    live: tuple[Crossing, ...]


def loss_plan(reach: Reach, rate: float) -> Plan:
    """The fault plan that drops these messages at a constant rate."""
    if rate == 0.0:
        return NO_FAULTS
    return Plan(name=f"loss-{rate:g}", rules=(Drop(probability=rate, kinds=reach.kinds),))


def rehearsed(scenario: Scenario, plan: Plan, seed: int) -> Crossing:
    """Rehearse one run."""
    world = Rehearsal(scenario, seed, plan).run().world
    assert world.judgement is not None, "the run is over"
    has_arrived = world.ending is Ending.ARRIVED
    broken = sum(world.judgement.violations.values())
    return Crossing(seed=seed, time_s=world.over_s if has_arrived else None, violations=broken)


def figures(points: Sequence[LossPoint]) -> list[Figure]:
    """The rehearsals of each point beside those without loss of the same seeds; live runs; what all broke."""
    free = {point.reach: _times_s(point.rehearsed) for point in points if point.rate == 0.0}
    found: list[Figure] = []
    for point in points:
        name = f"{100.0 * point.rate:.0f} % of {NAMES[point.reach]} lost"
        beside = {WITHOUT: free[point.reach]} if point.rate else None
        found.append(figure(name, UNIT, _times_s(point.rehearsed), baselines=beside, aim=_aim(point)))
        if point.live:
            found.append(figure(f"{name}, live", UNIT, _times_s(point.live)))
    broken = [each.violations for point in points for each in (*point.rehearsed, *point.live)]
    return [*found, figure("promises broken in a run", "", broken, aim=Aim(at_most=0.0, each=True))]


def _aim(point: LossPoint) -> Aim | None:
    if point.reach is not Reach.LINKS:
        return None
    return Aim(of=WITHOUT, at_most=BOUNDS[point.rate]) if point.rate in BOUNDS else Aim()


def _times_s(crossings: Sequence[Crossing]) -> list[float | None]:
    return [each.time_s for each in crossings]
