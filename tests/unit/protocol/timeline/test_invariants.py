"""How a broken promise is measured in a sentence."""

import pytest

from protocol.timeline.invariants import compared


@pytest.mark.parametrize(
    ("measured_m", "required_m", "said"),
    [
        (0.05, 0.08, "0.0500 m of 0.0800 m"),
        (-0.1, 0.0, "-0.1000 m of 0.0000 m"),
        (0.07998, 0.08, "0.079980 m of 0.080000 m"),
        (0.08 - 2e-9, 0.08, "0.079999998 m of 0.080000000 m"),
        (0.0, 0.0, ""),
        (None, None, ""),
    ],
)
def test_two_lengths_that_differ_are_told_apart_and_two_that_do_not_are_left_out(
    measured_m: float | None, required_m: float | None, said: str
) -> None:
    assert compared(measured_m, required_m, " of ") == said
