"""Progress messages for users who watch a run: one line per relevant entry."""

from protocol.keys import robot_name
from protocol.timeline import (
    Entry,
    FaultInjected,
    GoalReached,
    LeaderSucceeded,
    LinkBroken,
    PromiseBroken,
    Record,
    RobotArrived,
    RobotDied,
    RobotFailed,
    RobotRestarted,
    RobotReturned,
    RouteLost,
    RouterFound,
    RouterLost,
    RunEnded,
    StepAbandoned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    StrandReversed,
    WorldResumed,
)
from protocol.timeline.sentences import sentence

AWAITED: frozenset[type[Record]] = frozenset(
    {
        FaultInjected,
        GoalReached,
        LeaderSucceeded,
        LinkBroken,
        PromiseBroken,
        RobotArrived,
        RobotDied,
        RobotFailed,
        RobotRestarted,
        RobotReturned,
        RouteLost,
        RouterFound,
        RouterLost,
        RunEnded,
        StepAbandoned,
        StepPlanned,
        StrandDissolved,
        StrandFormed,
        StrandHealed,
        StrandReversed,
        WorldResumed,
    }
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None if it is not relevant."""
    record = entry.record
    if type(record) not in AWAITED:
        return None
    if isinstance(record, StrandFormed) and source != robot_name(record.order[0]):
        return None  # its leader tells of it
    if isinstance(record, FaultInjected) and record.process is None:
        return None  # messages are counted
    return f"t={entry.t_s:6.1f} s  {sentence(source, record)}"
