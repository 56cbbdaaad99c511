"""Progress for whoever watches a run: a line for each thing that people wait for."""

from protocol.keys import robot_name
from protocol.timeline import (
    Entry,
    GoalReached,
    PromiseBroken,
    RobotArrived,
    RobotDied,
    RouteLost,
    RunEnded,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
)


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None where nobody waits for it."""
    match entry.record:
        case StrandFormed(order=order) if source == robot_name(order[0]):
            said = f"strand formed: {' < '.join(map(robot_name, order))}"
        case StrandDissolved(blocked=blocked):
            said = f"the way of {robot_name(blocked)} is blocked: all line up again"
        case StepPlanned(step=step, length_m=length_m, promised_clearance_m=promised_m):
            promises = "" if promised_m is None else f", promises {promised_m:.3f} m"
            said = f"{source} plans step {step}: {length_m:.3f} m{promises}"
        case GoalReached():
            said = f"{source} has reached the goal"
        case RobotArrived(progress_m=progress_m):
            said = f"{source} has arrived, at {progress_m:.3f} m of the path"
        case RobotDied(robot=robot):
            said = f"{robot_name(robot)} has died"
        case RouteLost(reason=reason):
            said = f"{source} knows no way on: {reason}"
        case PromiseBroken(invariant=invariant, robot=robot, why=why):
            said = f"{invariant} broken by {robot_name(robot)}: {why}"
        case RunEnded(reason=reason):
            said = f"over: {reason}"
        case _:
            return None
    return f"t={entry.t_s:6.1f} s  {said}"
