"""Epochs number the views of the strand. Only their order has a meaning.

Rule 1: an epoch is generation, caller and count, in this order of weight. A run begins in generation 0.
Rule 2: a called epoch has a higher generation than any that its caller knows, and it contains the caller. No
        generation is behind the clock. So two robots never call the same epoch, nor does a restarted robot
        that has forgotten its earlier calls. Epochs without a new call increase the count.
Rule 3: a robot refuses an epoch whose generation is far ahead of its clock. Otherwise one message with the
        greatest possible number would leave no number for a later call.
"""

COUNTS = 10_000  # re-formations without a call: each takes seconds, so this is enough for a day
CALLERS = 10_000  # five times `ROBOTS_MAX`; a power of ten keeps epochs readable
PER_S = 10  # generations per second, the rate of the robots' messages
AHEAD_S = 100.0  # an odometry clock lags by seconds at most, and calls are seconds apart


def called_epoch(newest: int, caller: int, now_s: float) -> int:
    """The epoch that a robot calls if this is the newest epoch that it knows."""
    generation = max(newest // (COUNTS * CALLERS), int(now_s * PER_S)) + 1
    return (generation * CALLERS + caller) * COUNTS


def is_possible(epoch: int, now_s: float) -> bool:
    """Rule 3: whether the fleet can have reached this epoch by now."""
    return epoch // (COUNTS * CALLERS) <= (now_s + AHEAD_S) * PER_S


def is_called(epoch: int) -> bool:
    """Whether the epoch was called, or follows a called one."""
    return epoch >= COUNTS


def is_called_since(epoch: int, since_s: float) -> bool:
    """Whether the epoch was called after a time, or by a robot that knew of a call after it.

    Within the length of one generation the answer is no.
    """
    return epoch // (COUNTS * CALLERS) > since_s * PER_S + 1.0


def of_one_call(one: int, other: int) -> bool:
    """Whether two epochs belong to the same call."""
    return one // COUNTS == other // COUNTS
