"""Gaps: the openings between anti-clockwise neighbouring obstacles (Definition 1)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.navigation.obstacles import Obstacle
from protocol.arrays import Floats


@dataclass(frozen=True)
class Gap:
    """The opening between obstacle j' on its right and j'' on its left."""

    right: int
    """Index of j'."""
    left: int
    """Index of j''."""
    width_m: float
    """d: from p2 of j' to p1 of j''."""
    delta_rad: float
    """Angle of the gap seen from the switching position, in [0, 2 pi)."""
    axis_rad: float
    """Bearing of the tangent to j', from which the laws measure [world frame]."""
    middle: Floats
    """Its middle (2,) [m; world frame]."""


def find_gaps(obstacles: Sequence[Obstacle]) -> list[Gap]:
    """All gaps between neighbours; a single obstacle has none."""
    if len(obstacles) < 2:
        return []
    pairs = zip(range(len(obstacles)), [*range(1, len(obstacles)), 0], strict=True)
    return [_gap(obstacles, right, left) for right, left in pairs]


def is_passable(gap: Gap, *, passable_m: float) -> bool:
    """Whether (9) holds and the gap opens towards the robot, at an angle between 0 and pi."""
    return gap.width_m >= passable_m and 0.0 < gap.delta_rad < math.pi


def _gap(obstacles: Sequence[Obstacle], right: int, left: int) -> Gap:
    from_point, to_point = obstacles[right].tangent_2, obstacles[left].tangent_1
    axis = obstacles[right].bearing_2_rad
    return Gap(
        right,
        left,
        width_m=float(np.hypot(*(to_point - from_point))),
        delta_rad=(obstacles[left].bearing_1_rad - axis) % math.tau,
        axis_rad=axis,
        middle=(from_point + to_point) / 2.0,
    )
