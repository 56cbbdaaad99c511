"""One link of the strand, seen from one end: the neighbour's newest state, and how long it has been silent.

Rule 1: the newest state by (epoch, number) is kept; older ones and repeats change nothing.
Rule 2: a link is fresh as long as the neighbour has echoed something that this robot said not long ago. So
        one that works one way only is silent at both ends, and what was on its way for long renews nothing.
Rule 3: what part of the time it has been silent is a mean in which the last `LATELY_S` count most.
"""

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

from protocol.wire.messages import AheadState, BehindState

State = TypeVar("State", AheadState, BehindState)

LATELY_S = 10.0  # more than two silences that a link gets over


@dataclass(slots=True)
class Link(Generic[State]):
    """What is known of one neighbour."""

    neighbour: int
    made_at_s: float
    state: State | None = None
    silent: bool = False
    """Whether that has been said."""
    said_s: float = 0.0
    """When the neighbour said the newest that was heard, by its clock: what it is echoed."""
    heard_at_s: float = 0.0
    """When the newest was heard, or said where that is later: the neighbour has echoed nothing since."""
    silent_share: float = 0.0
    """Rule 3."""
    _noted_s: float = -1.0
    _echoed_s: float = -1.0
    _number: int = 0

    def hear(self, state: State, number: int, now_s: float) -> bool:
        """Take a state in; returns whether it is newer than what was known."""
        newest = (self.state.epoch if self.state else 0, self._number)
        if (state.epoch, number) <= newest or state.echo_s > now_s:
            return False
        self.state, self._number = state, number
        self.said_s = max(self.said_s, state.t_s)
        self.heard_at_s = max(now_s, state.t_s)
        if 0.0 < state.echo_s >= self.made_at_s:
            self._echoed_s = max(self._echoed_s, state.echo_s)
        return True

    @property
    def established(self) -> bool:
        """Whether the neighbour has ever echoed anything."""
        return self._echoed_s >= 0.0

    def silent_s(self, now_s: float) -> float:
        """How old the newest is that the neighbour has echoed [s]."""
        return now_s - max(self._echoed_s, self.made_at_s)

    def note(self, now_s: float, *, silence_s: float) -> None:
        """Rule 3: take in whether it is silent now; to be called again and again."""
        passed_s = now_s - max(self._noted_s, self.made_at_s)
        self._noted_s = now_s
        is_silent = self.silent_s(now_s) > silence_s
        self.silent_share += (is_silent - self.silent_share) * -math.expm1(-passed_s / LATELY_S)
