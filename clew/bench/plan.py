"""How long a leader's plans take, as a whole and by part, compared with a textbook planner.

Rule 1: the leader has no clock, so it is timed from outside: its functions are wrapped while scenarios are
        measured, and restored afterwards.
Rule 2: a part is the time of its functions; of nested functions only the outermost counts.
Rule 3: the textbook planner plans on each scan right after the leader.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from msgspec import Struct

from agents.navigation import guidance, step
from agents.navigation.scan import View
from agents.strand import leader
from clew.bench.result import Aim, Figure, figure
from clew.bench.textbook import Textbook
from clew.percentiles import percentile
from clew.rehearsal.rehearsal import Rehearsal
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
    "record": ((leader, "promised_clearance_m"),),
}


class Spread(Struct, frozen=True, kw_only=True):
    """Percentiles of a time over all plans."""

    median_ms: float
    p90_ms: float
    max_ms: float


class PlanFigures(Struct, frozen=True, kw_only=True):
    """How long plans took."""

    scenes: Sequence[str]
    plans: int
    plan_cpu: Spread
    plan_wall: Spread
    parts_cpu: Mapping[str, Spread]
    """The rest of the whole is the search among the certified ends, and bookkeeping."""
    textbook_cpu: Spread
    ratio: float
    """The leader's median divided by the textbook planner's median."""
    driven_m: float
    """The length of all steps that were planned."""
    plan_ms_per_m: float
    """CPU time of all plans for a metre of that; infinite, that is null, where there is none."""
    textbook_ms_per_m: float


@dataclass(frozen=True, slots=True)
class Sample:
    """How long one plan took [s]."""

    cpu_s: float
    wall_s: float
    parts_s: Mapping[str, float]
    textbook_s: float
    step_m: float = 0.0
    """The length of the step that was planned; 0: none was."""


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


def samples(scenario: Scenario, *, cpu: Clock, wall: Clock) -> list[Sample]:
    """Rehearse a scenario with a goal, and time each plan of its leader."""
    found: list[Sample] = []
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
        parts_s = {part: stopwatch.spent_s[part] for part in PARTS}
        step_m = planned.length_m if isinstance(planned, StepPlanned) else 0.0
        found.append(Sample(cpu_s, wall_s, parts_s, cpu() - since_cpu_s, step_m))
        return planned

    with ExitStack() as wrapped:
        wrapped.enter_context(_instead(leader.Leader, "plan", timed_plan))
        for part, functions in PARTS.items():
            for owner, name in functions:
                timed = stopwatch.timed(part, getattr(owner, name))
                wrapped.enter_context(_instead(owner, name, timed))
        Rehearsal(scenario, SEED).run()
    return found


def figures(scenes: Sequence[str], measured: Sequence[Sample]) -> PlanFigures:
    """Figures of the samples, of which there is at least one."""
    plan, textbook = (
        _spread([each.cpu_s for each in measured]),
        _spread([each.textbook_s for each in measured]),
    )
    driven_m = sum(each.step_m for each in measured)

    def per_m(time_s: float) -> float:
        return MS_PER_S * time_s / driven_m if driven_m else math.inf

    return PlanFigures(
        scenes=scenes,
        plans=len(measured),
        plan_cpu=plan,
        plan_wall=_spread([each.wall_s for each in measured]),
        parts_cpu={part: _spread([each.parts_s[part] for each in measured]) for part in PARTS},
        textbook_cpu=textbook,
        ratio=plan.median_ms / textbook.median_ms,
        driven_m=driven_m,
        plan_ms_per_m=per_m(sum(each.cpu_s for each in measured)),
        textbook_ms_per_m=per_m(sum(each.textbook_s for each in measured)),
    )


def common(name: str, repeats: Sequence[PlanFigures]) -> list[Figure]:
    """The figures of some repeats, beside the textbook planner's."""
    return [
        figure(
            f"{name}: a plan",
            "ms",
            [each.plan_cpu.median_ms for each in repeats],
            baselines={"textbook": [each.textbook_cpu.median_ms for each in repeats]},
            aim=Aim(of="textbook", at_most=RATIO_AIM),
        ),
        figure(
            f"{name}: plans for a metre",
            "ms/m",
            [each.plan_ms_per_m for each in repeats],
            baselines={"textbook": [each.textbook_ms_per_m for each in repeats]},
        ),
    ]


def _spread(times_s: Sequence[float]) -> Spread:
    median_ms, p90_ms, max_ms = (MS_PER_S * percentile(times_s, percent) for percent in (50, 90, 100))
    return Spread(median_ms=median_ms, p90_ms=p90_ms, max_ms=max_ms)


@contextmanager
def _instead(owner: Any, name: str, function: Callable[..., Any]) -> Iterator[None]:  # noqa: ANN401 - class or module
    """Replace a function for the time of the context."""
    before = getattr(owner, name)
    setattr(owner, name, function)
    try:
        yield
    finally:
        setattr(owner, name, before)
