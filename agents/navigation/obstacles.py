"""Obstacles as a robot sees them: runs of scan hits that nothing can pass between.

A scan does not identify obstacles. Two hits in neighbouring directions belong to one obstacle if they are
nearer to each other than the narrowest opening that the robot could pass, `2 (r + epsilon)` of (9). An
occluded obstacle is behind a jump in range; a jump wider than that separates two obstacles.
"""

from dataclasses import dataclass

import numpy as np

from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, of_next, of_previous


@dataclass(frozen=True)
class Obstacle:
    """The visible part of an obstacle, between its tangent points."""

    tangent_1: Floats
    """p1: the clockwise end of the run of hits (2,) [m; world frame]."""
    tangent_2: Floats
    """p2: the anti-clockwise end (2,)."""
    bearing_1_rad: float
    bearing_2_rad: float

    @property
    def chord_m(self) -> float:
        """L1 of (6): the distance between the tangent points."""
        return float(np.hypot(*(self.tangent_2 - self.tangent_1)))


def passable_width_m(keep_m: float) -> float:
    """(9): the narrowest opening that admits a robot and its clearance on both sides [m]."""
    return 2.0 * keep_m


def find_obstacles(view: View, *, passable_m: float) -> list[Obstacle]:
    """The obstacles of a scan, anti-clockwise; the first begins at or behind bearing -pi."""
    if not view.hits.any():
        return []
    joined = _joined_to_previous(view, passable_m)
    first_of_run = np.flatnonzero(view.hits & ~joined)
    last_of_run = np.flatnonzero(view.hits & ~of_next(joined))
    if len(first_of_run) == 0:  # hits all around, without an opening
        first_of_run, last_of_run = np.array([0]), np.array([len(view.hits) - 1])
    if last_of_run[0] < first_of_run[0]:  # a run across bearing -pi ends before it begins
        last_of_run = of_next(last_of_run)
    return [
        _obstacle(view, int(first), int(last)) for first, last in zip(first_of_run, last_of_run, strict=True)
    ]


def _joined_to_previous(view: View, passable_m: float) -> Flags:
    """Whether each direction's hit belongs to the same obstacle as the one clockwise of it (n,)."""
    apart = np.hypot(*(view.points - of_previous(view.points)).T)
    return np.asarray(view.hits & of_previous(view.hits) & (apart < passable_m))


def _obstacle(view: View, first: int, last: int) -> Obstacle:
    return Obstacle(
        view.points[first], view.points[last], float(view.bearings_rad[first]), float(view.bearings_rad[last])
    )
