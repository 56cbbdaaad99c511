import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.frames import Count, Length, Metres, Radians, RobotId, Seconds, Speed, wrap

angles_rad = st.one_of(
    st.floats(-100.0, 100.0),
    st.integers(-9, 9).map(lambda half_turns: half_turns * math.pi),
    st.integers(-9, 9).map(lambda half_turns: math.nextafter(half_turns * math.pi, math.inf)),
    st.integers(-9, 9).map(lambda half_turns: math.nextafter(half_turns * math.pi, -math.inf)),
)


@given(angles_rad)
def test_a_wrapped_angle_is_more_than_minus_pi_and_at_most_pi(angle_rad: float) -> None:
    assert -math.pi < wrap(angle_rad) <= math.pi


@given(angles_rad)
def test_a_wrapped_angle_has_the_same_direction(angle_rad: float) -> None:
    wrapped_rad = wrap(angle_rad)
    assert math.cos(wrapped_rad) == pytest.approx(math.cos(angle_rad), abs=1e-12)
    assert math.sin(wrapped_rad) == pytest.approx(math.sin(angle_rad), abs=1e-12)


@given(angles_rad)
def test_wrapping_is_idempotent(angle_rad: float) -> None:
    assert wrap(wrap(angle_rad)) == wrap(angle_rad)


def test_minus_pi_becomes_pi() -> None:
    assert wrap(-math.pi) == math.pi
    assert wrap(math.pi) == math.pi


@given(angles_rad)
def test_every_wrapped_angle_can_be_sent(angle_rad: float) -> None:
    assert msgspec.convert(wrap(angle_rad), Radians) == wrap(angle_rad)


@pytest.mark.parametrize("kind", [Metres, Length, Seconds, Speed, Radians])
@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_no_bounded_number_is_infinite_or_nan(kind: object, number: float) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(number, kind)


@pytest.mark.parametrize(
    ("kind", "number"),
    [
        (Metres, 1.1e6),
        (Length, -0.1),
        (Seconds, -0.1),
        (Speed, 101.0),
        (Radians, 3.2),
        (Count, -1),
        (Count, 2**53 + 1),
        (RobotId, 0),
        (RobotId, 10_000),
    ],
)
def test_a_number_out_of_its_bounds_is_refused(kind: object, number: float) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(number, kind)
