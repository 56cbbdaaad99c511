"""The ground that the robots behind may occupy."""

from dataclasses import dataclass

import numpy as np

from agents.navigation.certificate import Walls, ground_walls
from protocol.arrays import Floats
from protocol.path import Path


@dataclass(frozen=True)
class Ground:
    """The strand's path, and the parts of it that robots behind may occupy."""

    path: Path
    tail_m: float
    granted_m: float
    keep_m: float
    """Least distance to keep from it; 0 if no robot is behind."""
    behind_m: float
    """The last reported position of the robot directly behind."""

    @property
    def come(self) -> Floats:
        """The whole path (n, 2), along which the strand has come."""
        return self.path.between(0.0, self.path.end_m)

    @property
    def occupied(self) -> Floats:
        """The ground where robots behind may be now (n, 2), for guidance: hits on it are not remembered.

        A scan may be older than the newest news of the tail: it shows the tail a little further back.
        """
        from_m = max(min(self.tail_m, self.granted_m) - self.keep_m, 0.0)
        corners = self.path.between(from_m, self.granted_m)
        return corners if self.keep_m > 0.0 else corners[:1]

    @property
    def behind(self) -> Floats:
        """The ground on which hits are the robot directly behind (n, 2); one corner: there is none."""
        is_there = self.keep_m > 0.0
        return self.path.between(self.behind_m, self.granted_m) if is_there else self.occupied[:1]

    @property
    def walls(self) -> Walls:
        """The walls for a step: all ground that robots behind may reach."""
        return ground_walls(self._from_tail(self.granted_m), self.keep_m)

    @property
    def taken(self) -> Floats:
        """The same ground (n, 2) for guidance; empty if no robot is behind."""
        return self._from_tail(self.granted_m) if self.keep_m > 0.0 else np.empty((0, 2))

    def taken_from(self, leader_m: float) -> Floats:
        """The ground (n, 2) of the robots behind, closed up, if the leader stands at `leader_m`."""
        length_m = self.path.end_m - self.tail_m
        return self.path.between(max(leader_m - length_m, 0.0), max(leader_m - self.keep_m, 0.0))

    @property
    def taken_from_tail(self) -> Floats:
        """The ground (n, 2) of the robots ahead of the tail, for the tail."""
        end_m = self.path.end_m
        return self.path.between(min(self.tail_m + self.keep_m, end_m), end_m)

    def _from_tail(self, to_m: float) -> Floats:
        corners = self.path.between(min(self.tail_m, to_m), to_m)
        return corners if self.keep_m > 0.0 else corners[:1]
