"""All kinds of timeline entries, with their fields and units. `docs/timeline.md` is generated from them.

A kind is named noun.past_participle. The unit of a field is in its name; its description says the rest.
Positions are in the world frame. The page lists the kinds in the order of `Record`.
"""

from typing import Annotated, get_args

from msgspec import Meta, Struct

from protocol.frames import Count, Seconds
from protocol.timeline.base import Kind
from protocol.timeline.bodies import (
    BodyStopped,
    OrderAccepted,
    OrderFinished,
    OrderRefused,
    PoseSampled,
    ScanServed,
    StepFinished,
)
from protocol.timeline.messages import FaultInjected, MessageRefused, RobotSettled, TrafficCounted
from protocol.timeline.outcomes import (
    GoalReached,
    LawFailed,
    LawStalled,
    PromiseBroken,
    RobotArrived,
    RouteLost,
    RunEnded,
)
from protocol.timeline.processes import (
    RobotAppeared,
    RobotDied,
    RobotFailed,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RouterFound,
    RouterLost,
    WorldResumed,
)
from protocol.timeline.steps import SeenGap, SeenObstacle, SegmentChecked, StepAbandoned, StepPlanned
from protocol.timeline.strand import (
    AuthorityGranted,
    FenceChanged,
    LeaderSucceeded,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    RobotBlocked,
    RobotHeld,
    RobotPlaced,
    RobotReleased,
    RobotStranded,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    StrandJoined,
    StrandReversed,
    ViewJoined,
    ViewLeft,
    ViewProposed,
)

__all__ = [
    "AuthorityGranted",
    "BodyStopped",
    "Entry",
    "FaultInjected",
    "FenceChanged",
    "GoalReached",
    "LawFailed",
    "LawStalled",
    "LeaderSucceeded",
    "LinkBroken",
    "LinkHeard",
    "LinkSilent",
    "MessageRefused",
    "OrderAccepted",
    "OrderFinished",
    "OrderRefused",
    "PoseSampled",
    "PromiseBroken",
    "Record",
    "RobotAppeared",
    "RobotArrived",
    "RobotBlocked",
    "RobotDied",
    "RobotFailed",
    "RobotHeld",
    "RobotPlaced",
    "RobotReleased",
    "RobotRestarted",
    "RobotReturned",
    "RobotSettled",
    "RobotStarted",
    "RobotStranded",
    "RouteLost",
    "RouterFound",
    "RouterLost",
    "RunEnded",
    "ScanServed",
    "SeenGap",
    "SeenObstacle",
    "SegmentChecked",
    "StepAbandoned",
    "StepFinished",
    "StepPlanned",
    "StrandDissolved",
    "StrandFormed",
    "StrandHealed",
    "StrandJoined",
    "StrandReversed",
    "TrafficCounted",
    "ViewJoined",
    "ViewLeft",
    "ViewProposed",
    "WorldResumed",
]

Record = (
    RobotAppeared
    | RobotDied
    | RobotRestarted
    | RobotReturned
    | FenceChanged
    | OrderAccepted
    | OrderRefused
    | OrderFinished
    | StepFinished
    | StepAbandoned
    | BodyStopped
    | PoseSampled
    | ScanServed
    | PromiseBroken
    | MessageRefused
    | FaultInjected
    | RouterLost
    | RouterFound
    | WorldResumed
    | RunEnded
    | RobotStarted
    | RobotFailed
    | StrandFormed
    | StrandJoined
    | StrandReversed
    | StrandDissolved
    | RobotPlaced
    | RobotBlocked
    | RobotStranded
    | StepPlanned
    | SegmentChecked
    | AuthorityGranted
    | LinkSilent
    | LinkHeard
    | LinkBroken
    | ViewProposed
    | ViewJoined
    | ViewLeft
    | LeaderSucceeded
    | StrandHealed
    | RobotHeld
    | RobotReleased
    | GoalReached
    | RobotArrived
    | LawFailed
    | LawStalled
    | RouteLost
    | TrafficCounted
    | RobotSettled
)


class Entry(Struct, frozen=True, gc=False, kw_only=True):
    """One entry of the timeline: a time and a record. Its source is in the key of the message."""

    n: Annotated[Count, Meta(description="the source's own count, from 1")]
    t_s: Annotated[Seconds, Meta(description="simulated time")]
    hlc: Annotated[str, Meta(max_length=80, description="hybrid logical clock of the source")]
    record: Record


KINDS: dict[str, type[Kind]] = {str(kind.__struct_config__.tag): kind for kind in get_args(Record)}
"""All kinds, by their names in the log."""


def kind_of(record: Record) -> str:
    """The name of a record's kind."""
    return str(record.__struct_config__.tag)
