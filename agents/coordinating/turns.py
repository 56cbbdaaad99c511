"""The turns that a coordinator puts. Pure.

Rule 1 (F4): each turn number has one content. The coordinator puts the next number only when its own odometry
        has told this one, and repeats a put until then.
"""

from agents.commands import Command, Put
from agents.due import is_due
from agents.liveness.timing import Timing
from protocol.fence import Epoch, Fence, May, Turn


class Turns:
    """The turns of one epoch."""

    def __init__(self, epoch: Epoch, timing: Timing, now_s: float) -> None:
        self._epoch = epoch
        self._timing = timing
        self._newest: Fence | None = None
        self._put_at_s = now_s
        self._put_for: dict[int, int] = {}

    @property
    def newest(self) -> Fence | None:
        """The newest turn that was put."""
        return self._newest

    def put_for(self, robot: int) -> int:
        """The last turn that was put for a robot; 0: none."""
        return self._put_for.get(robot, 0)

    def are_told(self, fence: Fence) -> bool:
        """Whether odometry that tells this fence has told the newest turn."""
        return self._newest is None or fence.turn >= self._newest.turn

    def put(
        self, told: Fence, now_s: float, *, may: May, robot: int = 0, life: int = 0, members: int = 0
    ) -> list[Command]:
        """Put the turn after the one that odometry has told."""
        fence = Fence(epoch=self._epoch, turn=told.turn + 1, may=may, robot=robot, life=life, members=members)
        again = self._newest is not None and self._newest.turn == fence.turn
        assert not again or self._newest == fence, "one content for each turn number"
        self._newest, self._put_at_s = fence, now_s
        if may is May.ONE:
            self._put_for[robot] = fence.turn
        return [Put(Turn(fence=fence))]

    def repeat(self, now_s: float) -> list[Command]:
        """Put the newest turn again, if it is time."""
        newest = self._newest
        due = is_due(last_s=self._put_at_s, every_s=self._timing.put_s, now_s=now_s)
        if newest is None or not due:
            return []
        self._put_at_s = now_s
        return [Put(Turn(fence=newest))]
