"""Gaps: the openings between anti-clockwise neighbouring obstacles (Definition 1)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.navigation.obstacles import Obstacle
from protocol.arrays import Floats, of_next


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
    """Bearing of the tangent to j'; the laws measure angles from it [world frame]."""
    middle: Floats
    """Its middle (2,) [m; world frame]."""


def find_gaps(obstacles: Sequence[Obstacle]) -> list[Gap]:
    """All gaps between neighbours; a single obstacle has none."""
    if len(obstacles) < 2:
        return []
    from_points = np.array([each.tangent_2 for each in obstacles])
    to_points = of_next(np.array([each.tangent_1 for each in obstacles]))
    widths_m = np.hypot(*(to_points - from_points).T).tolist()
    middles = (from_points + to_points) / 2.0
    lefts = [*range(1, len(obstacles)), 0]
    return [
        Gap(
            right,
            left,
            width_m=widths_m[right],
            delta_rad=(obstacles[left].bearing_1_rad - obstacles[right].bearing_2_rad) % math.tau,
            axis_rad=obstacles[right].bearing_2_rad,
            middle=middles[right],
        )
        for right, left in enumerate(lefts)
    ]


def is_passable(gap: Gap, *, passable_m: float) -> bool:
    """Whether (9) holds and the gap opens towards the robot, at an angle between 0 and pi."""
    return gap.width_m >= passable_m and 0.0 < gap.delta_rad < math.pi
