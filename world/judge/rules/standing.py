"""Where bodies stood when the fence last let all move.

A body that has just stopped is sampled a moment later. So its place is the one between its last sample before
and its first sample after.
"""

from protocol.frames import Point
from protocol.timeline import PoseSampled

Sample = tuple[float, PoseSampled]


class Standing:
    """The places of all bodies at the newest fence ALL."""

    def __init__(self) -> None:
        self._all_s, self._epoch = 0.0, 0
        self._newest: dict[int, Sample] = {}
        self._before: dict[int, Sample] = {}
        self._after: dict[int, Sample] = {}

    def sampled(self, t_s: float, pose: PoseSampled) -> None:
        """A body has been sampled."""
        self._newest[pose.robot] = t_s, pose
        self._after.setdefault(pose.robot, (t_s, pose))

    def all_may_move(self, t_s: float, epoch: int) -> None:
        """The fence ALL of an epoch has come into force."""
        self._all_s, self._epoch = t_s, epoch
        self._before, self._after = dict(self._newest), {}

    def at(self, robot: int, epoch: int) -> Point | None:
        """Where a body stood; None if it has not been sampled since, or the epoch is not the newest."""
        if epoch != self._epoch or robot not in self._after or robot not in self._before:
            return None
        (start_s, start), (end_s, end) = self._before[robot], self._after[robot]
        share = (self._all_s - start_s) / (end_s - start_s) if end_s > start_s else 0.0
        return Point(
            x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m)
        )
