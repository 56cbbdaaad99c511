"""What tests ask of a rehearsal that suffers a fault plan."""

from collections import Counter

from lab.rehearsal import Rehearsal
from protocol.timeline import FaultInjected


def injected(rehearsal: Rehearsal) -> Counter[str]:
    """How often each fault has struck."""
    records = (entry.record for _, entry in rehearsal.entries)
    return Counter(record.fault for record in records if isinstance(record, FaultInjected))
