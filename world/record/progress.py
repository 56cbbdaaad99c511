"""Progress messages for users who watch a run: one line per relevant entry."""

from protocol.keys import robot_name
from protocol.timeline import (
    Entry,
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
)
from protocol.timeline.sentences import sentence

AWAITED = (
    GoalReached
    | LeaderSucceeded
    | LinkBroken
    | PromiseBroken
    | RobotArrived
    | RobotDied
    | RobotFailed
    | RobotRestarted
    | RobotReturned
    | RouteLost
    | RouterFound
    | RouterLost
    | RunEnded
    | StepAbandoned
    | StepPlanned
    | StrandDissolved
    | StrandHealed
    | StrandReversed
    | WorldResumed
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None if it is not relevant."""
    match entry.record:
        case StrandFormed(order=order):
            is_awaited = source == robot_name(order[0])
        case FaultInjected(process=process):
            is_awaited = process is not None
        case record:
            is_awaited = isinstance(record, AWAITED)
    return f"t={entry.t_s:6.1f} s  {sentence(source, entry.record)}" if is_awaited else None
