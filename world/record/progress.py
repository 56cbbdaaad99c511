"""Progress for whoever watches a run: a line for each thing that people wait for."""

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


def progress(source: str, entry: Entry) -> str | None:
    """The line for an entry; None where nobody waits for it."""
    for told in (_of_the_strand, _of_processes, _of_the_end):
        if (said := told(source, entry.record)) is not None:
            return f"t={entry.t_s:6.1f} s  {said}"
    return None


def _of_the_strand(source: str, record: Record) -> str | None:
    said: str | None = None
    match record:
        case StrandFormed(order=order) if source == robot_name(order[0]):
            said = f"strand formed: {' < '.join(map(robot_name, order))}"
        case StrandReversed():
            said = f"{source} has the strand turn round"
        case StrandDissolved(blocked=blocked):
            said = f"the way of {robot_name(blocked)} is blocked: all line up again"
        case StrandHealed(members=members):
            said = f"the strand has healed, of {len(members)} robots"
        case LeaderSucceeded(before=before):
            said = f"{source} leads" + ("" if before is None else f" in the place of {robot_name(before)}")
        case LinkBroken(neighbour=neighbour, silent_s=silent_s):
            said = f"{source} gives up its link to {robot_name(neighbour)}, silent for {silent_s:.1f} s"
        case StepAbandoned(step=step):
            said = f"{source} stops short in step {step}"
        case StepPlanned(joins=True, length_m=length_m):
            said = f"{source} goes {length_m:.3f} m towards its place"
        case StepPlanned(step=step, length_m=length_m, promised_clearance_m=promised_m):
            promises = "" if promised_m is None else f", promises {promised_m:.3f} m"
            said = f"{source} plans step {step}: {length_m:.3f} m{promises}"
        case _:
            pass
    return said


def _of_processes(source: str, record: Record) -> str | None:
    said: str | None = None
    match record:
        case FaultInjected(fault=fault, rule=rule, process=str(process)):
            said = f"{rule}: {fault} {process}"
        case RobotDied(robot=robot):
            said = f"{robot_name(robot)} has died"
        case RobotFailed(reason=reason):
            said = f"{source} has failed: {reason}"
        case RobotRestarted(robot=robot):
            said = f"{robot_name(robot)} has been started again"
        case RobotReturned(robot=robot):
            said = f"{robot_name(robot)} is there again"
        case RouterLost():
            said = "the router is lost"
        case RouterFound(away_s=away_s):
            said = f"a router is there again, after {away_s:.3f} s"
        case WorldResumed(entries=entries):
            said = f"the world goes on from {entries} entries"
        case _:
            pass
    return said


def _of_the_end(source: str, record: Record) -> str | None:
    said: str | None = None
    match record:
        case GoalReached():
            said = f"{source} has reached the goal"
        case RobotArrived(progress_m=progress_m):
            said = f"{source} has arrived, at {progress_m:.3f} m of the path"
        case RouteLost(reason=reason):
            said = f"{source} knows no way on: {reason}"
        case PromiseBroken(invariant=invariant, robot=robot, why=why):
            said = f"{invariant} broken by {robot_name(robot)}: {why}"
        case RunEnded(reason=reason):
            said = f"over: {reason}"
        case _:
            pass
    return said
