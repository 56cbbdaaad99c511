"""How robots that are left out are let in: they ask the leader, and the leader proposes a view. Liveness.

Rule 1: a leader lets the same robot in again after a time that doubles, to a limit, so that one that keeps
        failing does not stop the others all the time. The times when it has arrived count apart: by then
        others have moved out of the way, and before long the run is over for those that are left out.
Rule 2: it proposes that view when it next stands, or after `STOP_S`.
Rule 3: a leader lets in a robot that found no way to the strand only when a body has moved since; or if the
        leader has arrived, or knows no way on and that robot may lead.
"""

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from agents.commands import Command, Say
from agents.due import is_due
from agents.liveness.reason import Reason
from agents.liveness.timing import Timing
from protocol.fence import Cause, Fence, May
from protocol.wire.view import Plea

STOP_S = 5.0  # two steps of a strand in the open


@dataclass(slots=True)
class Pleas:
    """What one robot has asked for, what it has been asked for, and whom it has let in."""

    timing: Timing
    _asked: dict[int, float] = field(default_factory=dict)
    _has_arrived: bool = False
    """Whether this robot had, when it was asked last."""
    _let_in: Counter[tuple[int, bool]] = field(default_factory=Counter)
    """How often, by the robot and whether this one had arrived."""
    _not_before_s: dict[tuple[int, bool], float] = field(default_factory=dict)
    _said_at_s: float = -float("inf")
    _stranded_s: dict[int, float] = field(default_factory=dict)
    """When each robot was told to have found no way to the strand of this one."""

    def ask(self, plea: Plea, fence: Fence, now_s: float) -> list[Command]:
        """Ask the leader that odometry names to be let in, if it is time."""
        due = is_due(last_s=self._said_at_s, every_s=self.timing.plea_s, now_s=now_s)
        if not due or fence.may is not May.ALL:
            return []
        self._said_at_s = now_s
        return [Say(fence.robot, plea)]

    def forget(self) -> None:
        """There is a new view: who wants to be let in asks again."""
        self._asked.clear()

    def hear(self, robot: int, now_s: float, *, stood_s: float, arrived: bool, may_lead: bool) -> None:
        """A robot asks this leader to be let in (rules 1 and 3); all bodies have stood for `stood_s`.

        `arrived`: whether this leader has; `may_lead`: whether it knows no way on, and that robot may lead.
        """
        self._has_arrived = arrived
        is_stranded = now_s - self._stranded_s.get(robot, -float("inf")) <= stood_s + self.timing.gap_s
        if is_stranded and not (arrived or may_lead):
            return
        if now_s >= self._not_before_s.get((robot, arrived), 0.0):
            self._asked.setdefault(robot, now_s)

    def reason(self, now_s: float, *, stands: bool) -> Reason | None:
        """Rule 2."""
        for robot, asked_s in self._asked.items():
            if stands or now_s - asked_s > STOP_S:
                return Reason(Cause.PLEA, f"robot {robot} asks to be let in", robot)
        return None

    @property
    def asking(self) -> list[int]:
        """The robots that have asked, and may."""
        return list(self._asked)

    def note_stranded(self, robots: Collection[int], now_s: float) -> None:
        """These found no way to the strand of this robot, which leads it or may lead it later."""
        self._stranded_s.update(dict.fromkeys(robots, now_s))
        self.let_in(robots, now_s)

    def let_in(self, robots: Iterable[int], now_s: float) -> None:
        """A view has been proposed for these robots, or has found no way for them; both count once."""
        for key in [(robot, self._has_arrived) for robot in robots]:
            if now_s < self._not_before_s.get(key, 0.0):
                continue
            wait_s = self.timing.plea_again_s * 2.0 ** self._let_in[key]
            self._not_before_s[key] = now_s + min(wait_s, self.timing.plea_again_s_max)
            self._let_in[key] += 1
