"""The switching steps of the strand: when each was planned, begun and ended, and where. Pure.

Rule 1: a step is one that a leader has planned; the steps of a robot that joins are its own.
Rule 2: a step begins where its leader's body has taken the first order of it, and ends where it was finished
        or abandoned.
Rule 3: a step without such an end was broken off: when its leader died, or when the next step was planned.
Rule 4: a robot's entries may come late, so an end may be heard of before the plan.
"""

import math
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from clew.story.robots import Change
from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.timeline import Entry, OrderAccepted, StepAbandoned, StepFinished, StepPlanned, StrandFormed

KINDS = frozenset({OrderAccepted, StepAbandoned, StepFinished, StepPlanned, StrandFormed})


class Ending(StrEnum):
    """How a step ended."""

    FINISHED = "finished"
    ABANDONED = "abandoned"
    BROKEN_OFF = "broken off"


@dataclass(frozen=True, slots=True)
class Place:
    """Where a robot's body was, and when [world frame]."""

    t_s: float
    robot: int
    at: Point


@dataclass(frozen=True, slots=True)
class End:
    """How a step ended."""

    t_s: float
    how: Ending
    at: Point | None = None
    """None: nobody has recorded where."""
    clearance_m: float | None = None
    """The least of the whole step; None: no obstacle, or not finished."""


@dataclass(frozen=True, slots=True)
class Step:
    """A switching step."""

    number: int
    t_s: float
    """When it was planned."""
    robot: int
    """That led."""
    plan: StepPlanned
    begun: Place | None
    """None: no body has taken an order of it."""
    end: End | None
    """None: it is under way."""

    def __str__(self) -> str:
        plan, end = self.plan, self.end
        target = f"{plan.length_m:.3f} m to ({plan.target.x_m:.3f}, {plan.target.y_m:.3f})"
        said = f"step {self.number} of r{self.robot}: planned at t={self.t_s:.3f} s, {target}"
        if end is None:
            return f"{said}; under way"
        clear = "" if end.clearance_m is None else f", {end.clearance_m:.3f} m clear"
        return f"{said}; {end.how} at t={end.t_s:.3f} s{clear}"


@dataclass(slots=True)
class Way:
    """The way of one strand in arc length, which only grows at its end."""

    start_m: float
    """Where the leader stood when the strand formed."""
    turn: int
    """Of the fence that lets the strand drive."""
    goal_m: float | None = None
    """Where the goal is, as far as the leader knows."""
    _steps: list[int] = field(default_factory=list)
    _ends_m: list[float] = field(default_factory=list)

    def plan(self, plan: StepPlanned) -> None:
        """The leader has planned another step; one that was abandoned does not stand any more."""
        while self._ends_m and self._ends_m[-1] >= plan.reach_m:
            self._ends_m.pop()
            self._steps.pop()
        self._ends_m.append(plan.reach_m)
        self._steps.append(plan.step)
        self.goal_m = None if plan.cost_to_go_m is None else plan.reach_m + plan.cost_to_go_m

    def step_at(self, along_m: float) -> int | None:
        """The switching step to which a place belongs; None for what lies before the first."""
        if along_m <= self.start_m or not self._steps:
            return None
        return self._steps[min(bisect_left(self._ends_m, along_m), len(self._steps) - 1)]


@dataclass(slots=True)
class Steps:
    """All steps, as entries tell of them."""

    start: Place | None = None
    """Where the leader stood before the first step."""
    finished_count: int = 0
    newest: int = 0
    """The greatest number of a step that was planned."""
    ways: dict[int, Way] = field(default_factory=dict)
    """By epoch."""
    _plans: list[tuple[float, int, StepPlanned]] = field(default_factory=list)
    _begun: dict[tuple[int, int, int], Place] = field(default_factory=dict)
    """By robot, epoch and number."""
    _ends: defaultdict[tuple[int, int], list[End]] = field(default_factory=lambda: defaultdict(list))
    """By robot and number."""

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        match entry.record:
            case OrderAccepted(robot=robot, epoch=epoch, step=step) as order if step > 0:
                if (robot, epoch, step) not in self._begun:
                    place = Place(entry.t_s, robot, Point(x_m=order.x_m, y_m=order.y_m))
                    self._begun[robot, epoch, step] = place
                    if step == 1 and self.start is None:
                        self.start = place
            case StepFinished(robot=robot, step=step) as end if source == WORLD:
                at = Point(x_m=end.x_m, y_m=end.y_m)
                self._ends[robot, step].append(End(entry.t_s, Ending.FINISHED, at, end.clearance_m))
                self.finished_count += 1
            case StepAbandoned(step=step) as end if (robot := robot_number(source) or 0) > 0:
                at = Point(x_m=end.x_m, y_m=end.y_m)
                self._ends[robot, step].append(End(entry.t_s, Ending.ABANDONED, at))
            case StepPlanned(joins=False, epoch=epoch) as plan if (robot := robot_number(source) or 0) > 0:
                self._plans.append((entry.t_s, robot, plan))
                self.newest = max(self.newest, plan.step)
                if epoch in self.ways:
                    self.ways[epoch].plan(plan)
            case StrandFormed(epoch=epoch, turn=turn, places_m=(start_m, *_)):
                self.ways.setdefault(epoch, Way(start_m, turn))
            case _:
                pass  # nothing of a step

    def all(self, changes: Iterable[Change]) -> tuple[Step, ...]:
        """All steps in the order of their times; `changes`: of robots' states."""
        ended_s: defaultdict[int, list[float]] = defaultdict(list)
        for change in changes:
            if change.state.is_end:
                ended_s[change.robot].append(change.t_s)
        plans = sorted(self._plans, key=lambda each: each[0])
        next_s = [*(t_s for t_s, _, _ in plans[1:]), math.inf]
        return tuple(
            Step(
                number=plan.step,
                t_s=t_s,
                robot=robot,
                plan=plan,
                begun=self._begun.get((robot, plan.epoch, plan.step)),
                end=self._end(t_s, robot, plan, [after_s, *ended_s.get(robot, ())]),
            )
            for (t_s, robot, plan), after_s in zip(plans, next_s, strict=False)
        )

    def _end(self, t_s: float, robot: int, plan: StepPlanned, breaks_s: Sequence[float]) -> End | None:
        """Rules 2 and 3; `breaks_s`: when a step that was planned before is broken off."""
        told = next((end for end in self._ends.get((robot, plan.step), ()) if end.t_s >= t_s), None)
        if told is not None:
            return told
        broken_off_s = min(at_s for at_s in breaks_s if at_s >= t_s)
        return None if math.isinf(broken_off_s) else End(broken_off_s, Ending.BROKEN_OFF)


def gap_ends(plan: StepPlanned) -> tuple[tuple[Point, Point] | None, ...]:
    """Between which tangent points each gap opens, its right end first; None: its obstacles are not told."""
    seen, ends = plan.obstacles, list[tuple[Point, Point] | None]()
    for gap in plan.gaps:
        is_told = max(gap.right, gap.left) < len(seen)
        ends.append((seen[gap.right].tangent_2, seen[gap.left].tangent_1) if is_told else None)
    return tuple(ends)


def chosen_gap(plan: StepPlanned) -> tuple[Point, Point] | None:
    """The ends of the gap that was chosen; None: none was, or they are not told."""
    return None if plan.gap is None or plan.gap >= len(plan.gaps) else gap_ends(plan)[plan.gap]


def along_m(order: OrderAccepted, here: Point) -> float:
    """Where a body is on its strand's path, by the order that it drives: straight to a place on it."""
    if order.target is None:
        return order.reach_m
    return order.reach_m - math.hypot(order.target.x_m - here.x_m, order.target.y_m - here.y_m)
