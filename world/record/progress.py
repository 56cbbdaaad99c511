"""Progress messages for users who watch a run: one line per relevant entry."""

from protocol.timeline import Entry, FaultInjected, FenceChanged, kind_of
from protocol.timeline.sentences import sentence

AWAITED = frozenset(
    [
        "fault.injected",
        "fence.changed",
        "goal.reached",
        "law.failed",
        "law.stalled",
        "leader.succeeded",
        "link.broken",
        "promise.broken",
        "robot.arrived",
        "robot.died",
        "robot.failed",
        "robot.restarted",
        "robot.returned",
        "robot.stranded",
        "route.lost",
        "router.found",
        "router.lost",
        "run.ended",
        "step.abandoned",
        "step.planned",
        "strand.dissolved",
        "strand.formed",
        "strand.healed",
        "strand.reversed",
        "world.resumed",
    ]
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None if it is not relevant."""
    record = entry.record
    if kind_of(record) not in AWAITED:
        return None
    if isinstance(record, FenceChanged) and record.cause is None:
        return None  # turns are given many times while a strand lines up
    if isinstance(record, FaultInjected) and record.process is None:
        return None  # faults of messages are only counted
    return f"t={entry.t_s:6.1f} s  {sentence(source, record)}"
