"""How often a robot may raise the fence: protects the fleet from one that does so again and again.

Rule 1: a robot has `RAISES_MAX` raises. One comes back every `BACK_S`.
Rule 2: each view in a row that did not come to ALL doubles that time, up to `BACK_S_MAX`.

Rule 3: a view that another one of its generation or the operator has ended was not its robot's fault.
Rule 4: quotas follow from the fences alone. So a world that is started again has them from its timeline.

All are for liveness: no safety rests on a raise being taken, or refused.
"""

from dataclasses import dataclass, replace

from protocol.fence import NOBODY_NUMBER, Fence, May

RAISES_MAX = 6  # a healthy robot raises once for a loss, and once more for each further one
BACK_S = 10.0  # simulated: the last robot of a fleet may need one for each of its losses and ways
BACK_S_MAX = 600.0  # simulated


@dataclass(frozen=True, slots=True)
class Quota:
    """What is left of one robot's raises."""

    left: int = RAISES_MAX
    since_s: float = 0.0
    """From when on the next one is coming back [s; simulated]."""
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


class Quotas:
    """The quotas of all robots."""

    def __init__(self) -> None:
        self._of: dict[int, Quota] = {}
        """Of the robots that have raised."""

    def may_raise(self, robot: int, now_s: float) -> bool:
        """Whether a robot has a raise left."""
        return self._at(robot, now_s).left > 0

    def hear(self, before: Fence, fence: Fence, now_s: float) -> None:
        """The fence has changed."""
        old, new = before.epoch, fence.epoch
        if fence.may is May.ALL:
            self._end_view(new.robot, now_s, in_vain=False)
        elif old != new and new.robot != NOBODY_NUMBER:
            if before.may is not May.ALL and new.generation > old.generation:
                self._end_view(old.robot, now_s, in_vain=True)
            self._of[new.robot] = self._at(new.robot, now_s).used()

    def _end_view(self, robot: int, now_s: float, *, in_vain: bool) -> None:
        if robot != NOBODY_NUMBER:
            self._of[robot] = self._at(robot, now_s).after_view(in_vain=in_vain)

    def _at(self, robot: int, now_s: float) -> Quota:
        return self._of.get(robot, Quota()).at(now_s)
