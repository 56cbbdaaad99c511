"""The place that a robot had in a strand, and the path that it stands on there."""

from dataclasses import dataclass

import numpy as np

from protocol.arrays import nearest_on_segments
from protocol.frames import Point, Pose
from protocol.path import THERE_M, Path
from protocol.wire.messages import LEG_CORNERS_MAX, Former

COASTS_S = 2.0  # a robot that leaves a strand stands after that: its stop order, or the dead-man


@dataclass(frozen=True)
class Berth:
    """Where a robot was on a strand's path when it left the strand."""

    epoch: int
    rank: int
    progress_m: float
    path: Path
    """As far as it knew it."""
    speed_mps: float
    arrived: bool = False
    """Whether that was its place at the goal, behind the robots ahead."""

    def former(self, pose: Pose) -> Former:
        """Where it stands now, on the same path a little further on."""
        coasts_m = COASTS_S * self.speed_mps
        corners = self.path.between(self.progress_m, min(self.progress_m + coasts_m, self.path.end_m))
        lengths_m = np.hypot(*np.diff(corners, axis=0).T)
        place = np.array([pose.x_m, pose.y_m])
        nearest = nearest_on_segments(place, corners[:-1], corners[1:])
        segment = int(np.argmin(np.hypot(*(nearest - place).T)))
        along_m = float(lengths_m[:segment].sum() + np.hypot(*(nearest[segment] - corners[segment])))
        progress_m = min(self.progress_m + along_m, self.path.end_m)
        return Former(epoch=self.epoch, rank=self.rank, progress_m=progress_m)

    def leg(self, from_m: float, to_m: float) -> tuple[Point, ...] | None:
        """Corners of the way from one place to another; None where this robot does not know it all."""
        if to_m > self.path.end_m + THERE_M:
            return None
        inner = [
            Point(x_m=vertex.x_m, y_m=vertex.y_m)
            for vertex in self.path
            if from_m + THERE_M < vertex.s_m < to_m - THERE_M
        ]
        return tuple(inner) if len(inner) <= LEG_CORNERS_MAX else None
