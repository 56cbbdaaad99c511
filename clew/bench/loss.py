"""How much longer a fleet takes when messages are lost: rehearsed with several seeds, and live. Pure.

Rule 1: two curves: what robots say to each other is lost, and every message is, bodies and scans included.
Rule 2: a fleet that has not arrived when the scenario's time is up has no time; it is slower than any.
"""

import math
from collections.abc import Sequence
from enum import StrEnum

from msgspec import Struct

from clew.percentiles import percentile
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.rules import Drop, MessageKind
from world.judge.ending import Ending
from world.scenario.scenario import Scenario

RATES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9)
BOUND_RATE, BOUND = 0.5, 1.5  # at half of all loss on links, at most so many times the time without


class Reach(StrEnum):
    """Which messages are lost."""

    LINKS = "links"
    ALL = "all"

    @property
    def kinds(self) -> tuple[MessageKind, ...]:
        """As a fault plan says it; none is all."""
        return ("ahead", "behind", "muster", "beacon", "plea") if self is Reach.LINKS else ()


class Crossing(Struct, frozen=True, kw_only=True):
    """One run."""

    seed: int
    time_s: float | None
    """Simulated, until all had arrived; None: they had not when the run was over."""
    violations: int
    load: float | None = None
    """The machine's, of a live run."""


class LossPoint(Struct, frozen=True, kw_only=True):
    """All runs under one loss."""

    reach: Reach
    rate: float
    rehearsed: tuple[Crossing, ...]
    live: tuple[Crossing, ...]


def loss_plan(reach: Reach, rate: float) -> Plan:
    """The plan that loses so many of these messages, all alike, to the end."""
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


def median_s(crossings: Sequence[Crossing]) -> float:
    """The median time; infinite where most did not arrive."""
    return percentile(_times_s(crossings), 50)


def worst_s(crossings: Sequence[Crossing]) -> float:
    """The longest time; infinite where one did not arrive."""
    return max(_times_s(crossings))


def slowdown(points: Sequence[LossPoint]) -> float:
    """How many times longer a fleet takes at the loss that the bound is for, in the median of rehearsals."""
    by_rate = {point.rate: median_s(point.rehearsed) for point in points if point.reach is Reach.LINKS}
    return by_rate[BOUND_RATE] / by_rate[0.0]


def table(points: Sequence[LossPoint]) -> str:
    """The times in Markdown, a row for each rate."""
    rows = []
    for rate in sorted({point.rate for point in points}):
        cells = [f"{100.0 * rate:.0f} %"]
        for reach in Reach:
            (point,) = (each for each in points if (each.reach, each.rate) == (reach, rate))
            live = ", ".join(said_s(each.time_s) for each in point.live) or "-"
            cells += [said_s(median_s(point.rehearsed)), said_s(worst_s(point.rehearsed)), live]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(
        [
            "| loss | links: median, s | worst | live | every message: median, s | worst | live |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
        ]
    )


def said_s(time_s: float | None) -> str:
    """A time for people."""
    return f"{time_s:.1f}" if time_s is not None and math.isfinite(time_s) else "never"


def _times_s(crossings: Sequence[Crossing]) -> list[float]:
    return [math.inf if each.time_s is None else each.time_s for each in crossings]
