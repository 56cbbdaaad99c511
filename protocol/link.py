"""One link of the strand, seen from one end: the neighbour's newest state, and how long it has been silent.

Rule 1: the newest state by (epoch, number) is kept; older ones and repeats change nothing.
Rule 2: a state that repeats an old number does not end a silence: it may have been on its way for long.
"""

from dataclasses import dataclass
from typing import Generic, TypeVar

from protocol.messages import AheadState, BehindState

State = TypeVar("State", AheadState, BehindState)


@dataclass(slots=True)
class Link(Generic[State]):
    """What is known of one neighbour."""

    neighbour: int
    heard_at_s: float
    """When the newest state came; at first, when the link was made."""
    state: State | None = None
    silent: bool = False
    _number: int = 0

    def hear(self, state: State, number: int, now_s: float) -> bool:
        """Take a state in; returns whether it is newer than what was known."""
        newest = (self.state.epoch if self.state else 0, self._number)
        if (state.epoch, number) <= newest:
            return False
        self.state, self._number, self.heard_at_s = state, number, now_s
        return True

    def silent_s(self, now_s: float) -> float:
        """How long nothing new has been heard [s]."""
        return now_s - self.heard_at_s
