"""The way of one strand in arc length: its switching positions so far, and the goal behind them. Pure."""

import math
from bisect import bisect_left
from dataclasses import dataclass, field

from protocol.frames import Point
from protocol.timeline import OrderAccepted, StepPlanned


@dataclass(slots=True)
class Course:
    """Of one epoch, in which the path only grows at its end."""

    start_m: float
    """Where the leader stood when the strand formed."""
    steps: list[int] = field(default_factory=list)
    goal_m: float | None = None
    """Where the goal is, as far as the leader knows."""
    _ends_m: list[float] = field(default_factory=list)
    """Of the steps."""

    def plan(self, plan: StepPlanned) -> None:
        """The leader has planned another step; one that was abandoned does not stand any more."""
        while self._ends_m and self._ends_m[-1] >= plan.reach_m:
            self._ends_m.pop()
            self.steps.pop()
        self._ends_m.append(plan.reach_m)
        self.steps.append(plan.step)
        self.goal_m = None if plan.cost_to_go_m is None else plan.reach_m + plan.cost_to_go_m

    def step_at(self, along_m: float) -> int | None:
        """The switching step to which a place belongs; None for what lies before the first."""
        if along_m <= self.start_m or not self.steps:
            return None
        return self.steps[min(bisect_left(self._ends_m, along_m), len(self.steps) - 1)]


def along_m(order: OrderAccepted, here: Point) -> float:
    """Where a body is on its strand's path, by the order that it drives: straight to a place on it."""
    if order.target is None:
        return order.reach_m
    return order.reach_m - math.hypot(order.target.x_m - here.x_m, order.target.y_m - here.y_m)
