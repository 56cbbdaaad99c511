"""Queries of tests about a rehearsal with a fault plan."""

from collections import Counter

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import PLANS
from protocol.timeline import FaultInjected

SHIPPED = sorted(path.stem for path in PLANS.glob("*.toml"))


def injected(rehearsal: Rehearsal) -> Counter[str]:
    """The number of injections of each fault."""
    records = (entry.record for _, entry in rehearsal.entries)
    return Counter(record.fault for record in records if isinstance(record, FaultInjected))
