"""All moving obstacles of a run, packed: their positions, and their least distances to moving bodies.

Rule 1: between two changes of motion all velocities are constant, so a body moves straight relative to an
        obstacle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from protocol.arrays import Floats, Indices, distances_to_segments
from world.geometry.clearance import clearance
from world.geometry.moving import Moving, MovingPolygon
from world.geometry.shapes import Ground, ground_of


@dataclass(frozen=True, slots=True)
class Movers:
    """Obstacle k is row k, in the scenario's order."""

    names: tuple[str, ...]
    _tracks: Floats
    """`(K, n, 3)`: t, x, y; shorter tracks are padded with their last place at t = inf."""
    _turns_s: Floats
    """The times at which any of them changes its motion, in order."""
    _outlines: Ground
    """All outlines, each relative to its own place on its track."""
    _reach_m: Floats
    """The largest distance of each outline from that place."""
    _polygons: dict[int, Ground]
    """The outline of each polygon separately."""

    @classmethod
    def of(cls, moving: Sequence[Moving]) -> Self:
        """Pack a scenario's moving obstacles."""
        longest = max((len(each.track) for each in moving), default=0)
        return cls(
            names=tuple(each.id for each in moving),
            _tracks=np.array(
                [
                    [*each.track, *[(np.inf, *each.track[-1][1:])] * (1 + longest - len(each.track))]
                    for each in moving
                ]
            ).reshape(-1, 1 + longest, 3),
            _turns_s=np.unique([t_s for each in moving for t_s, _, _ in each.track]),
            _outlines=ground_of([each.outline for each in moving]),
            _reach_m=np.array([each.reach_m for each in moving], dtype=np.float64),
            _polygons={
                row: ground_of([each.outline])
                for row, each in enumerate(moving)
                if isinstance(each, MovingPolygon)
            },
        )

    def places_m(self, t_s: float) -> Floats:
        """Their positions on their tracks, `(K, 2)` [world frame]."""
        row, ahead = np.arange(len(self.names)), (self._tracks[:, :, 0] <= t_s).sum(axis=1)
        last, following = self._tracks[row, np.maximum(ahead - 1, 0)], self._tracks[row, ahead]
        leg_s = following[:, 0] - last[:, 0]  # 0 before a track begins, inf when it has ended
        share = (t_s - last[:, 0]) / np.where(leg_s > 0.0, leg_s, 1.0)
        return np.asarray(last[:, 1:] + share[:, None] * (following - last)[:, 1:])

    def among(self, ground: Ground, t_s: float) -> Ground:
        """The ground with the moving obstacles at their positions at that time."""
        if not self.names:
            return ground
        places_m, outlines = self.places_m(t_s), self._outlines
        circles, edges = outlines.circles.copy(), outlines.edges.copy()
        circles[:, :2] += places_m[outlines.circle_owner]
        edges += np.tile(places_m[outlines.edge_owner], 2)
        return replace(
            ground,
            shape_count=ground.shape_count + outlines.shape_count,
            circles=np.vstack((ground.circles, circles)),
            circle_owner=_joined(ground.circle_owner, ground.shape_count + outlines.circle_owner),
            edges=np.vstack((ground.edges, edges)),
            edge_owner=_joined(ground.edge_owner, ground.shape_count + outlines.edge_owner),
        )

    def approaches_m(
        self, starts_m: Floats, ends_m: Floats, *, from_s: float, to_s: float, near_m: float
    ) -> Floats:
        """The least distance of each body's centre from each obstacle, `(n, K)`, while both move; 0 inside.

        Args:
            starts_m: positions of the bodies at `from_s`, (n, 2) [world frame].
            ends_m: positions at `to_s`; in between they moved straight at constant speed.
            from_s: simulated time.
            to_s: likewise, later.
            near_m: larger distances may be underestimated, but never below this value.
        """
        turns_s = self._turns_s[(self._turns_s > from_s) & (self._turns_s < to_s)].tolist()
        least_m = np.full((len(starts_m), len(self.names)), np.inf)
        for begin_s, end_s in pairwise([from_s, *turns_s, to_s]):
            seen_m = [
                starts_m[:, None]
                + (ends_m - starts_m)[:, None] * ((t_s - from_s) / (to_s - from_s))
                - self.places_m(t_s)[None]
                for t_s in (begin_s, end_s)
            ]
            least_m = np.minimum(least_m, self._passes_m(seen_m[0], seen_m[1], near_m))
        return least_m

    def _passes_m(self, starts_m: Floats, ends_m: Floats, near_m: float) -> Floats:
        """The same for straight ways `(n, K, 2)`, each relative to its obstacle's place."""
        apart_m = distances_to_segments(np.zeros(2), starts_m, ends_m) - self._reach_m
        apart_m = np.maximum(apart_m, 0.0)
        near = apart_m <= near_m
        for row in np.flatnonzero(near.any(axis=0)).tolist():
            if row in self._polygons:
                body = np.flatnonzero(near[:, row])
                apart_m[body, row] = clearance(self._polygons[row], starts_m[body, row], ends_m[body, row])
        return apart_m


def _joined(one: Indices, other: Indices) -> Indices:
    return np.concatenate((one, other))
