"""The percentile rule of all figures: nearest rank.

The p-th percentile is the least value such that p % of all values are at most that value. It is always one of
the values, so it also holds where some are infinite, as the time of a fleet that never arrived is.
"""

from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T", int, float)


def percentile(values: Iterable[T], percent: int) -> T:
    """The percentile of these values, of which there is at least one; 50: the median, 100: the maximum."""
    ranked = sorted(values)
    return ranked[max(-(-percent * len(ranked) // 100), 1) - 1]
