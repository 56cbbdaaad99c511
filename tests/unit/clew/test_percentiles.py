from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from clew.percentiles import percentile


@pytest.mark.parametrize(
    ("values", "percent", "expected"),
    [
        ((3.0,), 0, 3.0),
        ((1, 2, 3, 4), 50, 2),
        (range(1, 21), 99, 20),
        ((1.0, inf, inf), 50, inf),
        ((1, inf), 50, 1),
    ],
)
def test_a_percentile_is_one_of_the_values(values: tuple[float, ...], percent: int, expected: float) -> None:
    assert percentile(values, percent) == expected


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30), st.integers(0, 100))
def test_numpy_says_the_same_by_its_inverted_distribution_function(values: list[float], percent: int) -> None:
    # numpy divides the percent by 100 first; half a unit less keeps it on the same side of each rank.
    asked = max(percent - 1e-9, 0.0)
    assert percentile(values, percent) == np.percentile(values, asked, method="inverted_cdf")
