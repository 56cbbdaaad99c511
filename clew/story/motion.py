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
        before = here if track is None else track.at
        moved_m = math.hypot(here.x_m - before.x_m, here.y_m - before.y_m)
        if track is None:
            self.tracks[robot] = Track(here)
        else:
            track.at, track.driven_m = here, track.driven_m + moved_m
        if track is None or moved_m > 0.0:
            self._moves.append((robot, before, here))
        return moved_m > 0.0

    def measure(self) -> None:
        """Bring the clearances up to date."""
        if not self._moves:
            return
        starts = np.array([(before.x_m, before.y_m) for _, before, _ in self._moves])
        ends = np.array([(here.x_m, here.y_m) for _, _, here in self._moves])
        least_m = clearance(self.ground, starts, ends) - self.radius_m
        for (robot, _, _), near_m in zip(self._moves, least_m.tolist(), strict=True):
            track = self.tracks[robot]
            track.clearance_m_min = min(track.clearance_m_min, near_m)
        self._moves.clear()
