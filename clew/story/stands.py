"""The switching positions of a run: where its steps began and ended, by the log's numbers of steps. Pure.

Rule 1: where step k began is k. Where a step ended and the next did not begin, or there was none, is "k end".
Rule 2: a step ends where it was finished or abandoned; one that was broken off, for another robot came to
        lead, where the body of its own was when the next began.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from clew.story.steps import Ending, Place, Step
from protocol.frames import Point

SAME_M = 1e-3  # a body that turns on the spot stays there; no step is so short


@dataclass(frozen=True, slots=True)
class Stand:
    """The leader at a switching position [world frame]."""

    t_s: float
    robot: int
    place: Point
    step: int
    ends: bool

    @property
    def name(self) -> str:
        """Rule 1."""
        return f"{self.step} end" if self.ends else str(self.step)


def stands_of(steps: Sequence[Step], place_at: Callable[[int, float], Point | None]) -> tuple[Stand, ...]:
    """The switching positions, by the steps, and where a robot's body was seen last at a time."""
    begun = [(step, step.begun) for step in steps if step.begun is not None]
    stands: list[Stand] = []
    for (step, place), (_, after) in zip(begun, [*begun[1:], (None, None)], strict=False):
        stand = Stand(place.t_s, step.robot, place.at, step.number, ends=False)
        if stands and stands[-1].ends and _are_same(stands[-1], stand):
            stands.pop()
        stands.append(stand)
        ended = _end(step, place, after, place_at)
        if ended is not None:
            stands.append(replace(stand, t_s=ended.t_s, place=ended.at, ends=True))
    return tuple(stands)


def _end(
    step: Step, begun: Place, after: Place | None, place_at: Callable[[int, float], Point | None]
) -> Place | None:
    """Rule 2; None: it goes on, or the same robot led on from wherever it was."""
    end = step.end
    if end is not None and end.how is not Ending.BROKEN_OFF and end.at is not None:
        return Place(end.t_s, step.robot, end.at)
    if after is None or after.robot == step.robot:
        return None
    return Place(after.t_s, step.robot, place_at(step.robot, after.t_s) or begun.at)


def _are_same(one: Stand, other: Stand) -> bool:
    return math.hypot(one.place.x_m - other.place.x_m, one.place.y_m - other.place.y_m) <= SAME_M
