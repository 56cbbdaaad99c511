"""One link of the strand, seen from one end: the neighbour's newest state, and how long it has been silent.

Rule 1: the newest state by (epoch, number) is kept; older states and repetitions change nothing.
Rule 2: a link is fresh as long as the neighbour echoes recent time stamps of this robot. So a link that works
        in one direction only is silent at both ends, and messages that were delayed for long renew nothing.
Rule 3: the silent share of the time is an exponential mean over the last `LATELY_S`.
"""

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

from protocol.wire.messages import AheadState, BehindState

State = TypeVar("State", AheadState, BehindState)

LATELY_S = 10.0  # longer than two silences that a link survives


@dataclass(slots=True)
class Link(Generic[State]):
    """The state of one neighbour, as far as it is known."""

    neighbour: int
    made_at_s: float
    state: State | None = None
    silent: bool = False
    """Whether the silence has been recorded."""
    said_s: float = 0.0
    """The time stamp of the newest message heard, by the neighbour's clock; it is echoed to the neighbour."""
    heard_at_s: float = 0.0
    """When the newest message was heard or, if that is later, sent: nothing was echoed since."""
    silent_share: float = 0.0
    """Rule 3."""
    _noted_s: float = -1.0
    _echoed_s: float = -1.0
    _number: int = 0

    def hear(self, state: State, number: int, now_s: float) -> bool:
        """Process a state; returns whether it is newer than the known one."""
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
        """Whether the neighbour has echoed any time stamp."""
        return self._echoed_s >= 0.0

    def silent_s(self, now_s: float) -> float:
        """The age of the newest time stamp that the neighbour has echoed [s]."""
        return now_s - max(self._echoed_s, self.made_at_s)

    def note(self, now_s: float, *, silence_s: float) -> None:
        """Rule 3: update the silent share; to be called regularly."""
        passed_s = now_s - max(self._noted_s, self.made_at_s)
        self._noted_s = now_s
        is_silent = self.silent_s(now_s) > silence_s
        self.silent_share += (is_silent - self.silent_share) * -math.expm1(-passed_s / LATELY_S)
