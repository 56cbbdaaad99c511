"""Progress for whoever watches a run: a line for each thing that people wait for."""

from protocol.keys import robot_name
from protocol.timeline import (
    Entry,
    FaultInjected,
    GoalReached,
    LeaderSucceeded,
    PromiseBroken,
    Record,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RouteLost,
    RouterFound,
    RouterLost,
    RunEnded,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    WorldResumed,
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None where nobody waits for it."""
    said = _went_on(source, entry.record) or _went_wrong(source, entry.record)
    return None if said is None else f"t={entry.t_s:6.1f} s  {said}"


def _went_on(source: str, record: Record) -> str | None:
    match record:
        case StrandFormed(order=order) if source == robot_name(order[0]):
            return f"strand formed: {' < '.join(map(robot_name, order))}"
        case StrandHealed(members=members):
            return f"the strand has healed, of {len(members)} robots"
        case StepPlanned(step=step, length_m=length_m, promised_clearance_m=promised_m):
            promises = "" if promised_m is None else f", promises {promised_m:.3f} m"
            return f"{source} plans step {step}: {length_m:.3f} m{promises}"
        case LeaderSucceeded(before=before):
            return (
                f"{source} leads"
                if before is None
                else f"{source} leads in the place of {robot_name(before)}"
            )
        case GoalReached():
            return f"{source} has reached the goal"
        case RobotArrived(progress_m=progress_m):
            return f"{source} has arrived, at {progress_m:.3f} m of the path"
        case RunEnded(reason=reason):
            return f"over: {reason}"
        case _:
            return None


def _went_wrong(source: str, record: Record) -> str | None:
    match record:
        case FaultInjected(fault=fault, rule=rule, process=str(process)):
            return f"{rule}: {fault} {process}"
        case RobotDied(robot=robot):
            return f"{robot_name(robot)} has died"
        case RobotRestarted(robot=robot):
            return f"{robot_name(robot)} has been started again"
        case RobotReturned(robot=robot):
            return f"{robot_name(robot)} is there again"
        case StrandDissolved(blocked=blocked):
            return f"the way of {robot_name(blocked)} is blocked: all line up again"
        case RouteLost(reason=reason):
            return f"{source} knows no way on: {reason}"
        case PromiseBroken(invariant=invariant, robot=robot, why=why):
            return f"{invariant} broken by {robot_name(robot)}: {why}"
        case _:
            return None
