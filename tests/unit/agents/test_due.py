"""What is repeated, by clocks that tell tenths of a second: `agents/due.py`."""

from hypothesis import given
from hypothesis import strategies as st

from agents.due import is_due

TENTHS = st.integers(0, 100_000)  # almost three hours
EVERY = st.integers(1, 100)


@given(TENTHS, EVERY)
def test_what_is_repeated_is_due_when_its_time_is_over_however_the_difference_rounds(
    last: int, every: int
) -> None:
    assert is_due(last_s=last / 10, every_s=every / 10, now_s=(last + every) / 10)


@given(TENTHS, EVERY)
def test_a_tenth_before_it_is_not(last: int, every: int) -> None:
    assert not is_due(last_s=last / 10, every_s=every / 10, now_s=(last + every - 1) / 10)
