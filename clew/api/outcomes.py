"""What came of two runs, figure by figure, by their verdicts. Pure.

Rule 1: a figure that neither run has is left out, such as the distance to moving obstacles where none moves.
Rule 2: if a robot died more than once, its first death counts.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from world.judge.recovery import Death
from world.judge.verdict import Verdict

Figure = float | int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One figure of both runs."""

    measure: str
    """A field of the verdict; or `lost_to_faults`, `noticed_s`, `healed_s`."""
    robot: int | None = None
    """The robot whose death it is about, if it is about one."""
    a: Figure
    """None: this run has no such figure."""
    b: Figure

    @property
    def difference(self) -> Figure:
        """B - A; None: one run has no such figure."""
        return None if self.a is None or self.b is None else self.b - self.a


MEASURES: dict[str, Callable[[Verdict], Figure]] = {
    "robots_arrived": lambda verdict: verdict.robots_arrived,
    "violations": lambda verdict: verdict.violations,
    "sim_s": lambda verdict: verdict.sim_s,
    "path_m": lambda verdict: verdict.path_m,
    "switching_steps": lambda verdict: verdict.switching_steps,
    "planning_events": lambda verdict: verdict.planning_events,
    "clearance_m_min": lambda verdict: verdict.clearance_m_min,
    "moving_clearance_m_min": lambda verdict: verdict.moving_clearance_m_min,
    "separation_m_min": lambda verdict: verdict.separation_m_min,
    "messages_sent": lambda verdict: verdict.messages.sent,
    "lost_to_faults": lambda verdict: (
        sum(verdict.messages.injected.values()) + sum(verdict.messages.injected_left_out.values())
    ),
}
OF_DEATHS: dict[str, Callable[[Death], Figure]] = {
    "noticed_s": lambda death: _after(death, death.detected_s),
    "healed_s": lambda death: _after(death, death.recovered_s),
}


def outcomes(a: Verdict | None, b: Verdict | None) -> tuple[Outcome, ...]:
    """All figures that at least one of the runs has; empty if one has no verdict."""
    if a is None or b is None:
        return ()
    return tuple(each for each in _outcomes(a, b) if each.a is not None or each.b is not None)


def _outcomes(a: Verdict, b: Verdict) -> Iterator[Outcome]:
    for measure, figure in MEASURES.items():
        yield Outcome(measure=measure, a=figure(a), b=figure(b))
    ours, theirs = map(_deaths, (a, b))
    for robot in sorted({*ours, *theirs}):
        one, other = ours.get(robot), theirs.get(robot)
        for measure, of_death in OF_DEATHS.items():
            figures = (None if death is None else of_death(death) for death in (one, other))
            yield Outcome(measure=measure, robot=robot, a=next(figures), b=next(figures))


def _deaths(verdict: Verdict) -> dict[int, Death]:
    """Rule 2."""
    return {death.robot: death for death in reversed(verdict.deaths)}


def _after(death: Death, then_s: float | None) -> Figure:
    return None if then_s is None else then_s - death.cause_s
