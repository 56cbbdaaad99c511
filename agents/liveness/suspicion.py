"""Whom a robot holds for lost, from tokens, silence and its own gaps. Pure; liveness only.

Rule 1: a neighbour is lost when its token has gone and it has not been heard since for a moment; or when it
        has been silent for too long. When no body has moved for long, it may not be silent at all: that it
        lives does not help those that wait for it.
Rule 2: a robot that has just had a gap of its own, or sees no token of the world, judges nobody. It has had
        one when its clock leaps: its process was late, or odometry was lost. It finds that before it handles
        anything that has waited meanwhile.
Rule 3: a neighbour that shows a token and is lost by silence again and again gets a penalty each time, which
        decays (route-flap damping, RFC 2439). While it is above the limit, this robot leaves it out of views.
"""

import math
from dataclasses import dataclass, field

from agents.liveness.presence import Presence
from agents.liveness.timing import Timing
from protocol.wire.link import Link
from protocol.wire.messages import AheadState, BehindState

HALF_LIFE_S = 30.0  # of a penalty
SUPPRESS = 0.75  # a loss adds 1: a robot is left out for 12 s, and for longer if it is lost again soon


@dataclass(slots=True)
class Suspicion:
    """What one robot knows of who is there."""

    timing: Timing
    presence: Presence = field(default_factory=Presence)
    _lived_s: float | None = None
    _awake_since_s: float = -float("inf")
    _one_at_s: dict[int, float] = field(default_factory=dict)
    """When each peer's penalty is 1, as it decays."""

    def live(self, now_s: float) -> None:
        """The robot's clock tells this time."""
        if self._lived_s is not None and now_s - self._lived_s > self.timing.gap_s:
            self._awake_since_s = now_s
        self._lived_s = now_s

    def judges(self, now_s: float) -> bool:
        """Rule 2."""
        return self.presence.connected and now_s - self._awake_since_s >= self.timing.listens_s

    def why_lost(
        self,
        link: Link[AheadState] | Link[BehindState],
        now_s: float,
        *,
        named_s: float = -math.inf,
        all_wait: bool = False,
    ) -> str | None:
        """Rule 1: `token` or `silence`; None: the neighbour may be there.

        Args:
            link: to the neighbour.
            now_s: the time.
            named_s: when the formation came that names it. The life that it names was there then, but may
                have ended before its ALL made the link.
            all_wait: whether no body has moved for long, though this robot has not arrived.
        """
        if not self.judges(now_s):
            return None
        if self.presence.is_lost(link.neighbour, max(link.heard_at_s, named_s), now_s):
            return "token"
        is_silent = link.silent_s(now_s) > self.timing.silent_s or (all_wait and link.silent)
        return "silence" if is_silent else None

    def has_gone(self, robot: int, heard_at_s: float, now_s: float) -> bool:
        """Whether a robot's token has gone, and it has not been heard since."""
        return self.judges(now_s) and self.presence.is_lost(robot, heard_at_s, now_s)

    def blame(self, robot: int, now_s: float, *, penalty: float = 1.0) -> None:
        """Rule 3: a robot that shows a token has been lost by silence, or keeps the others waiting."""
        value = penalty + self._penalty(robot, now_s)
        self._one_at_s[robot] = now_s + HALF_LIFE_S * math.log2(value)

    def suppressed(self, now_s: float) -> frozenset[int]:
        """Rule 3: whom this robot leaves out for now."""
        return frozenset(robot for robot in self._one_at_s if self._penalty(robot, now_s) > SUPPRESS)

    def _penalty(self, robot: int, now_s: float) -> float:
        return float(2.0 ** ((self._one_at_s.get(robot, -math.inf) - now_s) / HALF_LIFE_S))
