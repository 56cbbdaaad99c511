"""The laws of ours: `certified`, and the paper's `printed` and `resultant`.

The paper's laws make a step from the two obstacles beside a gap. All angles are measured from the axis, the
tangent to j' on the right of the gap. docs/paper.md says what these two laws promise and what they do not.
"""

import math
from collections.abc import Callable

from agents.navigation.law import Seen
from agents.navigation.step import (
    GAIN_M,
    Step,
    certified_step_onward,
    certified_step_through,
    certified_step_to,
    certified_step_to_goal,
    gaps_ahead,
    is_open,
)
from protocol.frames import wrap


def certified(seen: Seen) -> Step | str | None:
    """The certified step with the least cost-to-go; without a goal, one through the widest gap, or onward."""
    view, walls = seen.sight.view, seen.walls
    if seen.goal is not None and seen.ways is not None:
        step = certified_step_to(view, walls, seen.goal)
        step = step or certified_step_to_goal(view, walls, seen.ways())
        return step or "no certified step comes nearer to the goal"
    if (step := certified_step_through(seen.sight, walls, onward_rad=seen.onward_rad)) is not None:
        return step
    if is_open(seen.sight, seen.onward_rad):
        return None
    step = certified_step_onward(seen.sight, walls, onward_rad=seen.onward_rad)
    ahead = len(gaps_ahead(seen.sight, seen.onward_rad))
    return step or f"no certified step leads onward, and none nears one of {ahead} passable gaps ahead"


def printed(seen: Seen) -> Step | str:
    """Equation (14) as the paper prints it."""
    return _by_chords(seen, lambda *chords: printed_heading_rad(*chords[:3]))


def resultant(seen: Seen) -> Step | str:
    """The sum of vectors in the paper's text and Figure 2."""
    return _by_chords(seen, resultant_heading_rad)


def _by_chords(seen: Seen, heading_rad: Callable[[float, float, float, float], float]) -> Step | str:
    """A step through the widest passable gap, by its two chords.

    An obstacle hit by a single ray has no chord, so (12) gives no step.
    """
    chosen = seen.sight.widest_gap
    if chosen is None:
        return f"no passable gap in sight between {len(seen.obstacles)} obstacles"
    gap = seen.gaps[chosen]
    right_m, left_m = seen.obstacles[gap.right].chord_m, seen.obstacles[gap.left].chord_m
    length_m = step_length_m(right_m, left_m)
    if length_m < GAIN_M:
        return f"half the shorter chord beside the widest gap is {length_m:.4f} m, which is no step"
    beta = heading_rad(right_m, left_m, seen.mission.epsilon_m, gap.delta_rad)
    return Step(wrap(gap.axis_rad + beta), length_m, gap=chosen)


def obstacle_angle_rad(chord_m: float, epsilon_m: float) -> float:
    """(7)-(8): alpha, the angle of the right-angled triangle with legs L and 2 epsilon."""
    return math.atan2(2.0 * epsilon_m, chord_m)


def step_length_m(chord_right_m: float, chord_left_m: float) -> float:
    """(12): half the shorter of the two chords."""
    return min(chord_right_m, chord_left_m) / 2.0


def printed_heading_rad(chord_right_m: float, chord_left_m: float, epsilon_m: float) -> float:
    """(14) as printed: it does not depend on the angle of the gap."""
    return _direction(chord_right_m, chord_left_m, epsilon_m, left_sign=1.0, delta_rad=0.0)


def resultant_heading_rad(
    chord_right_m: float, chord_left_m: float, epsilon_m: float, delta_rad: float
) -> float:
    """The sum of L'/2 at alpha' and L''/2 at delta - alpha'', as text and Figure 2 describe."""
    return _direction(chord_right_m, chord_left_m, epsilon_m, left_sign=-1.0, delta_rad=delta_rad)


def _direction(
    chord_right_m: float, chord_left_m: float, epsilon_m: float, *, left_sign: float, delta_rad: float
) -> float:
    """Direction of the sum of two vectors, the left one at `delta + left_sign * alpha''`."""
    right = obstacle_angle_rad(chord_right_m, epsilon_m)
    left = delta_rad + left_sign * obstacle_angle_rad(chord_left_m, epsilon_m)
    return math.atan2(
        chord_right_m * math.sin(right) + chord_left_m * math.sin(left),
        chord_right_m * math.cos(right) + chord_left_m * math.cos(left),
    )
