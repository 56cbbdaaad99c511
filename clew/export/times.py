"""When an entry was made, in the time that other tools count: nanoseconds since 1970.

Rule 1: a simulated second is a second, whatever the run's speed; the first is when the run was started.
"""

from datetime import UTC, datetime

from protocol.errors import UsageError
from world.record.recorder import Header


def started_ns(header: Header) -> int:
    """When the run was started [ns since 1970]; 0 for a rehearsal.

    Raises:
        UsageError: the header says no time.
    """
    try:
        started = datetime.fromisoformat(header.started_at)
    except ValueError as error:
        raise UsageError(f"the header's started_at is no time: {header.started_at!r}") from error
    since = (started if started.tzinfo else started.replace(tzinfo=UTC)) - datetime(1970, 1, 1, tzinfo=UTC)
    return max((since.days * 86_400 + since.seconds) * 10**9 + since.microseconds * 1000, 0)


def at_ns(start_ns: int, t_s: float) -> int:
    """The time of an entry of a run that was started then."""
    return start_ns + round(t_s * 1e9)
