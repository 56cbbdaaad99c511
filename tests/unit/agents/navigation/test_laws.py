"""The paper's laws, equation by equation, and the counter-example to its Proposition 1."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.laws import (
    obstacle_angle_rad,
    printed_heading_rad,
    resultant_heading_rad,
    step_length_m,
)
from agents.navigation.step import NoStep
from tests.support.stages.one_step import MISSION, Driven, step_through, under, wall

CHORDS_M = st.floats(0.05, 5.0)
EPSILON_M = 0.1


def test_alpha_is_the_angle_of_the_triangle_with_legs_chord_and_twice_epsilon() -> None:
    assert math.tan(obstacle_angle_rad(0.8, EPSILON_M)) == pytest.approx(0.25)


def test_a_step_is_half_the_shorter_chord() -> None:
    assert step_length_m(0.6, 0.2) == step_length_m(0.2, 0.6) == 0.1


def test_the_printed_heading_can_lie_outside_the_bounds_of_15() -> None:
    chord_m, delta_rad = 1.0, 0.25
    alpha_rad = obstacle_angle_rad(chord_m, EPSILON_M)
    assert printed_heading_rad(chord_m, chord_m, EPSILON_M) > delta_rad - alpha_rad


@given(CHORDS_M, CHORDS_M, st.floats(0.0, 3.1))
def test_the_resultant_heading_lies_between_its_two_vectors(
    right_m: float, left_m: float, delta_rad: float
) -> None:
    right_rad = obstacle_angle_rad(right_m, EPSILON_M)
    left_rad = delta_rad - obstacle_angle_rad(left_m, EPSILON_M)
    beta_rad = resultant_heading_rad(right_m, left_m, EPSILON_M, delta_rad)
    assert min(right_rad, left_rad) - 1e-9 <= beta_rad <= max(right_rad, left_rad) + 1e-9


@given(CHORDS_M, st.floats(0.0, 3.1))
def test_with_equal_chords_the_resultant_halves_the_gap(chord_m: float, delta_rad: float) -> None:
    beta_rad = resultant_heading_rad(chord_m, chord_m, EPSILON_M, delta_rad)
    assert beta_rad == pytest.approx(delta_rad / 2.0, abs=1e-9)


# Proposition 1 says that a step of length (12) at the heading (14) keeps epsilon - mu0 from both obstacles.
# At distance s along the step the offset from the tangent to j' is s sin(beta), and the end of j' stands
# at s = l1'. So if j' is near and wide (l1' < L'/2), the step passes the end of j' at l1' sin(beta).
# Two thin walls of 1 m are an example: one ends 0.2 m ahead of the robot, on the axis; the other begins a
# metre away, 0.4 rad to the left.
NEAR_AND_WIDE = wall((0.2, 0.0), (0.2, -1.0))
FAR = wall((math.cos(0.4), math.sin(0.4) + 1.0), (math.cos(0.4), math.sin(0.4)))
COUNTER_EXAMPLE = [NEAR_AND_WIDE, FAR]
REQUIRED_M = MISSION.epsilon_m - MISSION.mu0_m


@pytest.mark.parametrize("law", ["printed", "resultant"])
def test_proposition_1_does_not_hold_past_an_obstacle_that_is_near_and_wide(law: str) -> None:
    driven = step_through(COUNTER_EXAMPLE, under(law))
    assert isinstance(driven, Driven)
    assert driven.planned.length_m == pytest.approx(0.5, abs=0.01), "half the chords, as (12) says"
    assert driven.clearance_m == pytest.approx(0.2 * math.sin(driven.planned.heading_rad), abs=0.002)
    assert driven.clearance_m < REQUIRED_M / 2.0


def test_the_certified_law_survives_the_counter_example() -> None:
    driven = step_through(COUNTER_EXAMPLE, under("certified"))
    assert isinstance(driven, Driven)
    assert driven.planned.promised_clearance_m is not None
    assert driven.clearance_m >= driven.planned.promised_clearance_m >= REQUIRED_M


@pytest.mark.parametrize("law", ["printed", "resultant"])
def test_the_paper_laws_give_no_step_without_two_obstacles(law: str) -> None:
    assert isinstance(step_through([], under(law)), NoStep)
    assert isinstance(step_through([NEAR_AND_WIDE], under(law)), NoStep)
