"""The ground that the strand behind a robot takes up."""

from dataclasses import dataclass

import numpy as np

from agents.navigation.certificate import Walls, ground_walls
from protocol.arrays import Floats
from protocol.path import Path


@dataclass(frozen=True)
class Ground:
    """The strand's path, and how much of it robots behind may be on."""

    path: Path
    tail_m: float
    granted_m: float
    keep_m: float
    """Least distance to keep from it; 0 where nobody is behind."""
    behind_m: float
    """Where the robot right behind was, when it was last heard."""
    occupied_m: float
    """How far it may have come by now."""

    @property
    def occupied(self) -> Floats:
        """Where robots behind may be now (n, 2)."""
        return self._from_tail(self.occupied_m)

    @property
    def behind(self) -> Floats:
        """Where the robot right behind may be now (n, 2)."""
        return self.path.between(self.behind_m, self.occupied_m) if self.keep_m > 0.0 else self.occupied[:1]

    @property
    def walls(self) -> Walls:
        """What a step has to keep off: all ground that robots behind may come to."""
        return ground_walls(self._from_tail(self.granted_m), self.keep_m)

    @property
    def taken(self) -> Floats:
        """The same ground (n, 2), for guidance; empty where nobody is behind."""
        return self._from_tail(self.granted_m) if self.keep_m > 0.0 else np.empty((0, 2))

    def taken_from(self, leader_m: float) -> Floats:
        """What ground (n, 2) the robots behind take up if the leader stands there, as close as they are."""
        length_m = self.path.end_m - self.tail_m
        return self.path.between(max(leader_m - length_m, 0.0), max(leader_m - self.keep_m, 0.0))

    def _from_tail(self, to_m: float) -> Floats:
        corners = self.path.between(min(self.tail_m, to_m), to_m)
        return corners if self.keep_m > 0.0 else corners[:1]
