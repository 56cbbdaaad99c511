"""The time of an entry in the unit of other tools: nanoseconds since 1970.

Rule 1: a simulated second counts as one second at any speed of the run. Time zero is the start of the run.
"""

from datetime import UTC, datetime

from protocol.errors import UsageError
from world.record.recorder import Header


def started_ns(header: Header) -> int:
    """The start of the run [ns since 1970]; 0 for a rehearsal.

    Raises:
        UsageError: the header has no valid time.
    """
    try:
        started = datetime.fromisoformat(header.started_at)
    except ValueError as error:
        raise UsageError(f"the header's started_at is not a time: {header.started_at!r}") from error
    since = (started if started.tzinfo else started.replace(tzinfo=UTC)) - datetime(1970, 1, 1, tzinfo=UTC)
    return max((since.days * 86_400 + since.seconds) * 10**9 + since.microseconds * 1000, 0)


def at_ns(start_ns: int, t_s: float) -> int:
    """The time of an entry [ns since 1970], for a run with this start."""
    return start_ns + round(t_s * 1e9)
