"""The paper's laws `printed` and `resultant`: a switching step from the two obstacles beside a gap.

All angles are measured from the axis, the tangent to j' on the right of the gap. docs/paper.md says what the
two laws promise and what they do not.
"""

import math

from protocol.mission import Law


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


def heading_rad(
    law: Law, chord_right_m: float, chord_left_m: float, epsilon_m: float, delta_rad: float
) -> float:
    """Beta of one of the two paper laws."""
    assert law is not Law.CERTIFIED, "the certified law does not steer by chords"
    if law is Law.PRINTED:
        return printed_heading_rad(chord_right_m, chord_left_m, epsilon_m)
    return resultant_heading_rad(chord_right_m, chord_left_m, epsilon_m, delta_rad)


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
