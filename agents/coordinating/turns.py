"""The turns that a coordinator puts. Pure.

Rule 1 (F4): each turn number has one content. The coordinator puts the next number only when its own odometry
        has told this one, and repeats a put until then.
Rule 2 (liveness): a turn is idle while its robot stands, less the time for which it has driven. So a robot of
        which most messages are lost, and which drives a little between long pauses, has no more time than
        one that only stands.
"""

from collections import Counter
from dataclasses import dataclass, field

from agents.commands import Command, Put
from agents.due import is_due
from agents.liveness.timing import Timing
from protocol.fence import Fence, May, Turn
from protocol.wire.messages import Odometry


@dataclass(slots=True)
class Turns:
    """The turns of one epoch."""

    newest: Fence
    """The newest turn that was put; at first turn 0, which is the raise."""
    timing: Timing
    _watched_s: float
    """When bodies were watched last; at first: since when there is the view."""
    put_for: Counter[int] = field(default_factory=Counter)
    """The last turn that was put for each robot; 0: none. Few have one, where most are in place."""
    idle_s: float = 0.0
    """For how much longer bodies have stood than driven in the newest robot's turn (rule 2)."""
    _put_at_s: float = -float("inf")

    def watch(self, odometry: Odometry, now_s: float) -> None:
        """Note whether a body moves, by the newest odometry."""
        passed_s, self._watched_s = now_s - self._watched_s, now_s
        drives = odometry.stood_s < self.timing.put_s
        self.idle_s = max(0.0, self.idle_s - passed_s if drives else self.idle_s + passed_s)

    @property
    def holder(self) -> int:
        """The robot for which the newest turn was put; 0: none."""
        return self.newest.robot if self.newest.may is May.ONE else 0

    def are_told(self, fence: Fence) -> bool:
        """Whether odometry that tells this fence has told the newest turn."""
        return fence.turn >= self.newest.turn

    def put(
        self, told: Fence, now_s: float, *, may: May, robot: int = 0, life: int = 0, members: int = 0
    ) -> list[Command]:
        """Put the turn after the one that odometry has told."""
        epoch, turn = self.newest.epoch, told.turn + 1
        fence = Fence(epoch=epoch, turn=turn, may=may, robot=robot, life=life, members=members)
        assert self.newest.turn != turn or self.newest == fence, "one content for each turn number"
        self.newest, self._put_at_s = fence, now_s
        if may is May.ONE:
            self.put_for[robot], self.idle_s = turn, 0.0
        return [Put(Turn(fence=fence))]

    def repeat(self, now_s: float) -> list[Command]:
        """Put the newest turn again, if it is time."""
        if not is_due(last_s=self._put_at_s, every_s=self.timing.put_s, now_s=now_s):
            return []
        self._put_at_s = now_s
        return [Put(Turn(fence=self.newest))]
