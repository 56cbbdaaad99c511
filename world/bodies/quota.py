"""How often a robot may raise the fence: protects the fleet from one that does so again and again.

Rule 1: a robot has `RAISES_MAX` raises. One comes back every `BACK_S`.
Rule 2: each view in a row that did not come to ALL doubles that time, up to `BACK_S_MAX`.

Both are for liveness: no safety rests on a raise being taken, or refused.
"""

from dataclasses import dataclass, replace

RAISES_MAX = 6  # a healthy robot raises once for a loss, and once more for each further one
BACK_S = 30.0  # simulated
BACK_S_MAX = 600.0  # simulated


@dataclass(frozen=True, slots=True)
class Quota:
    """What is left of one robot's raises."""

    left: int = RAISES_MAX
    since_s: float = 0.0
    """From when on the next one is coming back."""
    in_vain: int = 0
    """How many of its views in a row did not come to ALL."""

    @property
    def back_every_s(self) -> float:
        """Rule 2."""
        doublings = min(self.in_vain, int(BACK_S_MAX / BACK_S))  # no power without a bound
        return min(BACK_S * 2.0**doublings, BACK_S_MAX)

    def at(self, now_s: float) -> "Quota":
        """The quota at this time."""
        back = int((now_s - self.since_s) / self.back_every_s)
        if self.left + back >= RAISES_MAX:
            return replace(self, left=RAISES_MAX, since_s=now_s)
        return replace(self, left=self.left + back, since_s=self.since_s + back * self.back_every_s)

    def used(self) -> "Quota":
        """The quota after a raise."""
        return replace(self, left=self.left - 1)

    def after_view(self, *, in_vain: bool) -> "Quota":
        """The quota after a view of the robot."""
        return replace(self, in_vain=self.in_vain + 1 if in_vain else 0)
