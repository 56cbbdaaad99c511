"""Periodic actions, for clocks that count in tenths of a second."""

ROUNDING_S = 1e-6  # rounding error of time differences: less than a tick


def is_due(*, last_s: float, every_s: float, now_s: float) -> bool:
    """Whether the period has passed, up to rounding."""
    return now_s - last_s >= every_s - ROUNDING_S
