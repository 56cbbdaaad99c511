"""Progress for whoever watches a run: a line for each thing that people wait for."""

from protocol.keys import robot_name
from protocol.timeline import (
    Entry,
    GoalReached,
    PromiseBroken,
    RobotArrived,
    RobotDied,
    RouteLost,
    RouterFound,
    RouterLost,
    RunEnded,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    WorldResumed,
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
            return _of_process(entry)
    return _line(entry, said)


def _of_process(entry: Entry) -> str | None:
    """The line for what happened to a router or to the world."""
    match entry.record:
        case RouterLost():
            return _line(entry, "the router is lost")
        case RouterFound(away_s=away_s):
            return _line(entry, f"a router is there again, after {away_s:.3f} s")
        case WorldResumed(entries=entries):
            return _line(entry, f"the world goes on from {entries} entries")
        case _:
            return None


def _line(entry: Entry, said: str) -> str:
    return f"t={entry.t_s:6.1f} s  {said}"
