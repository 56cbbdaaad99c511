"""How long a leader's plans take, as a whole and by part, compared with a textbook planner.

Rule 1: the leader has no clock, so it is timed from outside: its functions are wrapped while scenarios are
        measured, and restored afterwards.
Rule 2: a part is the time of its functions; of nested functions only the outermost counts.
Rule 3: the textbook planner, and the peers that are installed, plan on each scan right after the leader.
Rule 4: a peer chooses velocities for a period. What it drives in that is its metres: for a metre it plans as
        often as it would in a run.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, Protocol
from unittest.mock import patch

from msgspec import Struct

from agents.navigation import guidance, record, step
from agents.navigation.scan import View
from agents.strand import leader
from clew.bench.planners.textbook import Textbook
from clew.bench.result import Aim, Figure, figure
from clew.percentiles import percentile
from clew.rehearsal.rehearsal import Rehearsal
from protocol.mission import Mission
from protocol.timeline import StepPlanned
from world.scenario.scenario import Scenario

Clock = Callable[[], float]

SEED = 1  # of every rehearsal; the leader's way hardly depends on it
MS_PER_S = 1000.0
RATIO_AIM = 0.5  # of the textbook planner's time
PARTS: Mapping[str, Sequence[tuple[Any, str]]] = {
    "perceive": ((leader, "look"), (leader, "scan_walls")),
    "certify": ((step, "certified_lengths_m"),),
    "guide": (
        (guidance.Map, "remember"),
        (guidance.Map, "cost_to_go"),
        (guidance.CostToGo, "at"),
        (guidance.CostToGo, "way_from"),
    ),
    "record": ((record, "promised_clearance_m"),),
}


class Spread(Struct, frozen=True, kw_only=True):
    """Percentiles of a time over all plans."""

    median_ms: float
    p90_ms: float
    max_ms: float


class PeerFigures(Struct, frozen=True, kw_only=True):
    """How long a peer's plans took on the same scans."""

    cpu: Spread
    ms_per_m: float
    """As `plan_ms_per_m`, for what it drives until its next plan."""


class PlanFigures(Struct, frozen=True, kw_only=True):
    """How long plans took."""

    scenes: Sequence[str]
    plans: int
    plan_cpu: Spread
    plan_wall: Spread
    parts_cpu: Mapping[str, Spread]
    """The rest of the whole is the search among the certified ends, and bookkeeping."""
    textbook_cpu: Spread
    driven_m: float
    """The length of all steps that were planned."""
    plan_ms_per_m: float
    """CPU time of all plans for a metre of that; infinite, that is null, where there is none."""
    textbook_ms_per_m: float
    peers: Mapping[str, PeerFigures] = {}


class Planner(Protocol):
    """A peer, made for a mission with a goal."""

    def plan(self, view: View) -> float:
        """Plan on a scan; returns how far the robot drives until its next plan [m]."""
        ...


Peers = Mapping[str, Callable[[Mission], Planner]]


@dataclass(frozen=True, slots=True)
class Sample:
    """How long one plan took [s]."""

    cpu_s: float
    wall_s: float
    parts_s: Mapping[str, float]
    textbook_s: float
    step_m: float = 0.0
    """The length of the step that was planned; 0: none was."""
    peers: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """How long each peer's plan took [s], and how far the peer drives until its next plan [m]."""


class Stopwatch:
    """Adds up the time that functions take, by part."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._is_running = False
        self.spent_s: defaultdict[str, float] = defaultdict(float)

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function with its time added to this part."""

        def call(*arguments: object, **options: object) -> object:
            if self._is_running:
                return function(*arguments, **options)
            self._is_running, since_s = True, self._clock()
            try:
                return function(*arguments, **options)
            finally:
                self.spent_s[part] += self._clock() - since_s
                self._is_running = False

        return call


def samples(scenario: Scenario, *, cpu: Clock, wall: Clock, peers: Peers | None = None) -> list[Sample]:
    """Rehearse a scenario with a goal, and time each plan of its leader."""
    found: list[Sample] = []
    planners = {name: make(scenario.mission()) for name, make in (peers or {}).items()}
    textbook, stopwatch, plan = Textbook(scenario.mission()), Stopwatch(cpu), leader.Leader.plan

    def timed_plan(
        self: leader.Leader,
        view: View,
        *arguments: Any,  # noqa: ANN401 - whatever a plan takes
        **options: Any,  # noqa: ANN401 - whatever a plan takes
    ) -> leader.Plan:
        stopwatch.spent_s.clear()
        since_cpu_s, since_wall_s = cpu(), wall()
        planned = plan(self, view, *arguments, **options)
        cpu_s, wall_s, since_cpu_s = cpu() - since_cpu_s, wall() - since_wall_s, cpu()
        textbook.plan(view)
        textbook_s = cpu() - since_cpu_s
        parts_s = {part: stopwatch.spent_s[part] for part in PARTS}
        step_m = planned.length_m if isinstance(planned, StepPlanned) else 0.0
        beside = {name: peer_plan(planner, view, cpu) for name, planner in planners.items()}
        found.append(Sample(cpu_s, wall_s, parts_s, textbook_s, step_m, beside))
        return planned

    with ExitStack() as wrapped:
        wrapped.enter_context(patch.object(leader.Leader, "plan", timed_plan))
        for part, functions in PARTS.items():
            for owner, name in functions:
                timed = stopwatch.timed(part, getattr(owner, name))
                wrapped.enter_context(patch.object(owner, name, timed))
        Rehearsal(scenario, SEED).run()
    return found


def peer_plan(planner: Planner, view: View, cpu: Clock) -> tuple[float, float]:
    """How long a peer's plan takes [s], and how far the peer drives until its next plan [m]."""
    since_s = cpu()
    driven_m = planner.plan(view)
    return cpu() - since_s, driven_m


def figures(scenes: Sequence[str], measured: Sequence[Sample]) -> PlanFigures:
    """Figures of the samples, of which there is at least one."""
    driven_m = sum(each.step_m for each in measured)
    return PlanFigures(
        scenes=scenes,
        plans=len(measured),
        plan_cpu=_spread([each.cpu_s for each in measured]),
        plan_wall=_spread([each.wall_s for each in measured]),
        parts_cpu={part: _spread([each.parts_s[part] for each in measured]) for part in measured[0].parts_s},
        textbook_cpu=_spread([each.textbook_s for each in measured]),
        driven_m=driven_m,
        plan_ms_per_m=_ms_per_m(sum(each.cpu_s for each in measured), driven_m),
        textbook_ms_per_m=_ms_per_m(sum(each.textbook_s for each in measured), driven_m),
        peers={name: _peer([each.peers[name] for each in measured]) for name in measured[0].peers},
    )


def _peer(plans: Sequence[tuple[float, float]]) -> PeerFigures:
    times_s, driven_m = zip(*plans, strict=True)
    return PeerFigures(cpu=_spread(times_s), ms_per_m=_ms_per_m(sum(times_s), sum(driven_m)))


def _ms_per_m(time_s: float, driven_m: float) -> float:
    return MS_PER_S * time_s / driven_m if driven_m else math.inf


def common(name: str, repeats: Sequence[PlanFigures]) -> list[Figure]:
    """The figures of some repeats, beside those of the textbook planner and of the peers; then the parts."""
    peers = repeats[0].peers
    return [
        figure(
            f"{name}: a plan",
            "ms",
            [each.plan_cpu.median_ms for each in repeats],
            baselines={
                "textbook": [each.textbook_cpu.median_ms for each in repeats],
                **{name: [each.peers[name].cpu.median_ms for each in repeats] for name in peers},
            },
            aim=Aim(of="textbook", at_most=RATIO_AIM),
        ),
        figure(
            f"{name}: plans for a metre",
            "ms/m",
            [each.plan_ms_per_m for each in repeats],
            baselines={
                "textbook": [each.textbook_ms_per_m for each in repeats],
                **{name: [each.peers[name].ms_per_m for each in repeats] for name in peers},
            },
        ),
        *(
            figure(f"{name}: {part}", "ms", [each.parts_cpu[part].median_ms for each in repeats])
            for part in repeats[0].parts_cpu
        ),
    ]


def _spread(times_s: Sequence[float]) -> Spread:
    median_ms, p90_ms, max_ms = (MS_PER_S * percentile(times_s, percent) for percent in (50, 90, 100))
    return Spread(median_ms=median_ms, p90_ms=p90_ms, max_ms=max_ms)
