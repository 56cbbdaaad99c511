"""What the sampled poses of all bodies say: how far each has driven, and how near it came to obstacles. Pure.

Between two samples a body moved straight: by that rule the verdict is judged, so the two agree.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from protocol.frames import Point
from world.geometry.clearance import clearance
from world.geometry.shapes import Ground


@dataclass(slots=True)
class Track:
    """One body's."""

    at: Point
    """[world frame]"""
    driven_m: float = 0.0
    clearance_m_min: float = math.inf

    def move(self, here: Point) -> float:
        """The body is here now; returns how far it has come from where it was [m]."""
        moved_m = math.hypot(here.x_m - self.at.x_m, here.y_m - self.at.y_m)
        self.at, self.driven_m = here, self.driven_m + moved_m
        return moved_m

    def pass_by(self, near_m: float) -> None:
        """The body has come so near to an obstacle."""
        self.clearance_m_min = min(self.clearance_m_min, near_m)


@dataclass(slots=True)
class Motion:
    """All bodies'. Distances are measured in one go, when somebody looks."""

    ground: Ground
    radius_m: float
    tracks: dict[int, Track] = field(default_factory=dict)
    _moves: list[tuple[int, Point, Point]] = field(default_factory=list)

    def see(self, robot: int, here: Point) -> bool:
        """A body has been seen; returns whether it has moved."""
        track = self.tracks.get(robot)
        if track is None:
            self.tracks[robot] = Track(here)
            self._moves.append((robot, here, here))
            return False
        before = track.at
        has_moved = track.move(here) > 0.0
        if has_moved:
            self._moves.append((robot, before, here))
        return has_moved

    def measure(self) -> None:
        """Bring the clearances up to date."""
        if not self._moves:
            return
        starts = np.array([(before.x_m, before.y_m) for _, before, _ in self._moves])
        ends = np.array([(here.x_m, here.y_m) for _, _, here in self._moves])
        least_m = clearance(self.ground, starts, ends) - self.radius_m
        for (robot, _, _), near_m in zip(self._moves, least_m.tolist(), strict=True):
            self.tracks[robot].pass_by(near_m)
        self._moves.clear()
