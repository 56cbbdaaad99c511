"""Epochs: how often the strand has re-formed, and who called it; only their order has a meaning.

Rule 1: an epoch is generation, caller and count, in this order of weight. The run begins in generation 0.
Rule 2: a called epoch is of a higher generation than any that its caller has heard of, and names the caller;
        and no generation is behind the time. So two robots never call the same, nor does one that has been
        started again and knows nothing of what it called before. The epochs that follow it count on.
Rule 3: a robot refuses an epoch whose generation is far ahead of the time. Otherwise one message with the
        greatest number there is would leave no number for any later call.
"""

COUNTS = 10_000  # re-formations without a call: each takes seconds, so this is a day of nothing else
CALLERS = 10_000  # five times `ROBOTS_MAX`, so that the figures can be read
PER_S = 10  # generations: robots speak so often
AHEAD_S = 100.0  # a clock told by odometry lags by seconds at most; calls come seconds apart


def called_epoch(newest: int, caller: int, now_s: float) -> int:
    """The epoch that a robot calls which has heard of none newer than this."""
    generation = max(newest // (COUNTS * CALLERS), int(now_s * PER_S)) + 1
    return (generation * CALLERS + caller) * COUNTS


def is_possible(epoch: int, now_s: float) -> bool:
    """Rule 3: whether robots can have come to this epoch by now."""
    return epoch // (COUNTS * CALLERS) <= (now_s + AHEAD_S) * PER_S


def is_called(epoch: int) -> bool:
    """Whether somebody called it, or one that it follows."""
    return epoch >= COUNTS


def is_called_since(epoch: int, since_s: float) -> bool:
    """Whether it was called after a time, or by somebody who had heard of one that was.

    In doubt, by the length of a generation, it was not.
    """
    return epoch // (COUNTS * CALLERS) > since_s * PER_S + 1.0


def of_one_call(one: int, other: int) -> bool:
    """Whether one of two epochs follows the other without a call between them."""
    return one // COUNTS == other // COUNTS
