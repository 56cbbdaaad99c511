"""What tests ask of a rehearsal that suffers a fault plan."""

from collections import Counter

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import PLANS
from protocol.timeline import FaultInjected

SHIPPED = sorted(path.stem for path in PLANS.glob("*.toml"))


def injected(rehearsal: Rehearsal) -> Counter[str]:
    """How often each fault has struck."""
    records = (entry.record for _, entry in rehearsal.entries)
    return Counter(record.fault for record in records if isinstance(record, FaultInjected))
