"""Progress messages for users who watch a run: one line per relevant entry."""

from protocol.timeline import Entry, FaultInjected
from protocol.timeline.sentences import sentence

AWAITED = frozenset(
    [
        "fault.injected",
        "goal.reached",
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
        "view.proposed",
        "world.resumed",
    ]
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None if it is not relevant."""
    record = entry.record
    if record.__struct_config__.tag not in AWAITED:
        return None
    if isinstance(record, FaultInjected) and record.process is None:
        return None  # faults of messages are only counted
    return f"t={entry.t_s:6.1f} s  {sentence(source, record)}"
