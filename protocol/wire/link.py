"""One link of the strand, seen from one end: the neighbour's newest state, and how long it has been silent.

Rule 1 (safety): a link is to one life of a robot in one epoch. A state of another life or epoch is void, and
        nothing is taken from it.
Rule 2 (safety): the newest state by its number is kept; older states and repetitions change nothing.
Rule 3 (liveness): how long a link has been silent is the age of the newest time stamp that was heard, by the
        world's clock. So messages that were delayed for long renew nothing.
"""

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

from protocol.fence import Epoch, Life
from protocol.wire.messages import AheadState, BehindState

State = TypeVar("State", AheadState, BehindState)


@dataclass(slots=True)
class Link(Generic[State]):
    """The state of one neighbour, as far as it is known."""

    neighbour: int
    life: Life
    epoch: Epoch
    made_at_s: float
    state: State | None = None
    heard_at_s: float = -math.inf
    """The newest time stamp heard; one that is ahead of the own time counts as that."""
    silent: bool = False
    """Whether the silence has been noted."""
    _number: int = 0

    def is_from(self, robot: int, state: AheadState | BehindState) -> bool:
        """Rule 1."""
        return (robot, state.life, state.epoch) == (self.neighbour, self.life, self.epoch)

    def is_newer(self, number: int) -> bool:
        """Whether a state with this number is newer than the known one (rule 2)."""
        return number > self._number

    def hear(self, state: State, number: int, now_s: float) -> bool:
        """Take in a valid state; returns whether it is newer than the known one."""
        if not self.is_newer(number):
            return False
        self.state, self._number = state, number
        self.heard_at_s = max(self.heard_at_s, min(state.t_s, now_s))
        return True

    def silent_s(self, now_s: float) -> float:
        """Rule 3."""
        return max(0.0, now_s - max(self.heard_at_s, self.made_at_s))

    def note(self, now_s: float, *, silence_s: float) -> bool:
        """To be called regularly; returns whether the link has fallen silent, or is heard again."""
        was_silent = self.silent
        # As by `silent_s`: it is called several times in each event.
        self.silent = now_s - self.heard_at_s > silence_s and now_s - self.made_at_s > silence_s
        return self.silent != was_silent
