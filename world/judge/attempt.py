"""What a fleet was trying last: for a run whose time was up before it had arrived."""

from dataclasses import dataclass, field

from protocol.fence import Cause, May
from protocol.timeline import (
    Entry,
    FenceChanged,
    GoalReached,
    StepAbandoned,
    StepFinished,
    StepPlanned,
    StrandFormed,
    StrandReversed,
    ViewProposed,
)
from protocol.timeline.sentences import CAUSES

BACKS = "the strand was backing out of a dead end since {}"
LEADS = "the tail was to lead the strand out of a dead end since {}"


@dataclass(slots=True)
class Attempt:
    """The newest step or view of the fleet, from the timeline."""

    turns: int = 0
    """How often the strand has turned round."""
    goal_reached: bool = False
    _step: tuple[str, StepPlanned] | None = None
    _ended_s: float | None = None
    """When the newest step ended; None while it is driven."""
    _instead: str | None = None
    """What the strand has done instead of a step, and since when, if no step has been planned since."""
    _view_s: float | None = None
    """Since when a view has been forming; None while all may drive."""
    _causes: dict[int, Cause] = field(default_factory=dict)
    _epoch: int = 0

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry."""
        match entry.record:
            case ViewProposed(epoch=epoch, cause=cause):
                self._causes[epoch] = cause
                if cause is Cause.NO_WAY:
                    self._instead = f"a leader had known no way on by t={entry.t_s:.1f} s"
            case FenceChanged(may=May.ALL):
                self._view_s, self._causes = None, {}
            case FenceChanged(epoch=epoch):
                self._view_s, self._epoch = entry.t_s if self._view_s is None else self._view_s, epoch
            case StrandReversed(back_by_m=back_by_m):
                self.turns += 1
                self._instead = (BACKS if back_by_m > 0.0 else LEADS).format(f"t={entry.t_s:.1f} s")
            case StrandFormed():
                self.goal_reached = False
            case GoalReached():
                self.goal_reached = True
            case StepPlanned(joins=False) as step:
                self._step, self._ended_s, self._instead = (source, step), None, None
            case StepFinished() | StepAbandoned():
                self._ended_s = entry.t_s
            case _:
                pass  # nothing that is tried

    @property
    def sentence(self) -> str:
        """What was tried last, for the end of a sentence."""
        times = "once" if self.turns == 1 else f"{self.turns} times"
        turned = f"; the strand had turned round {times}" if self.turns > 0 else ""
        return f"{self._newest}{turned}"

    @property
    def _newest(self) -> str:
        if self._view_s is not None:
            cause = self._causes.get(self._epoch)
            why = "" if cause is None else f" ({CAUSES[cause]})"
            return f"the robots had been forming a strand since t={self._view_s:.1f} s{why}"
        if self.goal_reached:
            return "the leader had reached the goal, and others were on the way to their places"
        if self._instead is not None:
            return self._instead
        if self._step is None:
            return "no step had been planned"
        source, step = self._step
        if self._ended_s is not None:
            return f"{source} had found no step after step {step.step} since t={self._ended_s:.1f} s"
        left = (
            ""
            if step.cost_to_go_m is None
            else f", which ends about {step.cost_to_go_m:.1f} m before the goal"
        )
        return f"{source} was driving step {step.step}{left}"
