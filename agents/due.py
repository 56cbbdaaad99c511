"""What is repeated every so often, by clocks that tell the time in tenths of a second."""

ROUNDING_S = 1e-6  # of the differences of times: less than a tick


def is_due(*, last_s: float, every_s: float, now_s: float) -> bool:
    """Whether it is time again; a difference that is short by its rounding is not short."""
    return now_s - last_s >= every_s - ROUNDING_S
