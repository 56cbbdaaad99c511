"""The paths of strands: what the formation laid, and then where the leader's switching steps end.

Rule 1: arc length 0 is where the laid path begins, at the tail.
Rule 2: a step that was abandoned ends where the leader stopped, any other at its target. So the path is
        certain up to the beginning of the newest step, and what follows may still change.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from protocol.frames import Point
from protocol.path import Path
from protocol.timeline import Record, StepAbandoned, StepPlanned, StrandFormed

JOINS = 0  # for all steps of a robot that joins; a leader's count from 1

Plan = tuple[float, Point]
"""When a step was planned, and its target."""


@dataclass(slots=True)
class _Led:
    """The steps of one robot in one epoch."""

    plans: dict[int, list[Plan]] = field(default_factory=dict)
    """By step, or `JOINS`."""
    steps: list[int] = field(default_factory=list)
    """All steps, in order."""
    ends: dict[int, Point] = field(default_factory=dict)
    abandoned: set[int] = field(default_factory=set)
    finished: int = 0
    """The newest step that its body has finished."""
    path: Path | None = None
    """The path with all steps; None: it has to be built."""

    def plan(self, t_s: float, plan: StepPlanned) -> None:
        """The robot has planned a step."""
        self.plans.setdefault(JOINS if plan.joins else plan.step, []).append((t_s, plan.target))
        if not plan.joins and plan.step not in self.abandoned:
            self.end(plan.step, plan.target)

    def end(self, step: int, end: Point) -> None:
        """A step ends there, as far as is known."""
        is_new, is_last = step not in self.ends, not self.steps or step >= self.steps[-1]
        self.ends[step] = end
        if is_new:
            self.steps.append(step)
        if self.path is None:
            return
        if not is_last:
            self.steps.sort()
            self.path = None
        elif is_new:
            self.path.extend(end)
        else:
            self.path.stretch(end)

    def along(self, strand: StrandFormed) -> Path:
        """The path of the strand that the robot leads."""
        if self.path is None:
            self.steps.sort()
            self.path = Path((*strand.laid, *(self.ends[step] for step in self.steps)))
        return self.path

    def finish(self, step: int) -> None:
        """The body has finished a step."""
        self.finished = step

    @property
    def is_certain(self) -> bool:
        """Whether the newest step has ended for good."""
        return bool(self.steps) and (self.steps[-1] in self.abandoned or self.steps[-1] == self.finished)


class Paths:
    """What leaders and joining robots planned so far."""

    def __init__(self) -> None:
        self._led: dict[tuple[int, int], _Led] = {}
        """By robot and epoch."""

    def hear(self, robot: int, t_s: float, record: Record) -> None:
        """Process an entry of a robot."""
        match record:
            case StepPlanned() as plan:
                self._of(robot, plan.epoch).plan(t_s, plan)
            case StepAbandoned() as step:
                led = self._of(robot, step.epoch)
                led.abandoned.add(step.step)
                led.end(step.step, Point(x_m=step.x_m, y_m=step.y_m))
            case _:
                pass  # plans nothing

    def finish(self, robot: int, epoch: int, step: int) -> None:
        """The body of a leader has finished a step."""
        self._of(robot, epoch).finish(step)

    def plans(self, robot: int, epoch: int, step: int) -> Sequence[Plan]:
        """What a robot has planned for a step, or as `JOINS`, in order of time."""
        led = self._led.get((robot, epoch))
        return () if led is None else led.plans.get(step, ())

    def of(self, strand: StrandFormed) -> Path | None:
        """The strand's path so far; None if its formation has none."""
        return self._of(strand.order[0], strand.epoch).along(strand) if strand.laid else None

    def certain_m(self, strand: StrandFormed) -> float:
        """Rule 2: the arc length up to which the path does not change any more."""
        led = self._of(strand.order[0], strand.epoch)
        path = led.along(strand)
        return path[-2].s_m if led.steps and not led.is_certain else path.end_m

    def forget(self, kept: Collection[int]) -> None:
        """Drop all other epochs."""
        self._led = {key: led for key, led in self._led.items() if key[1] in kept}

    def _of(self, robot: int, epoch: int) -> _Led:
        return self._led.setdefault((robot, epoch), _Led())
