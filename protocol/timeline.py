"""Every kind of timeline entry, with its fields and units. `docs/timeline.md` is made from this file.

A kind is named noun.past_participle. A field's unit is in its name; what more there is to say is in
its description. Positions are in the world frame.
"""

from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Count, Length, Metres, Point, Radians, RobotId, Seconds
from protocol.mission import Law

Text = Annotated[str, Meta(max_length=2000)]
Counts = Annotated[dict[Annotated[str, Meta(max_length=200)], Count], Meta(max_length=20_000)]


class _Record(Struct, frozen=True, kw_only=True, tag_field="kind"):
    """What all kinds share; the fields of `Entry` come before its own."""


# --- what the world records -----------------------------------------------------------------------


class RobotAppeared(_Record, frozen=True, kw_only=True, tag="robot.appeared"):
    """The world has seen a robot's liveliness token."""

    robot: RobotId


class RobotDied(_Record, frozen=True, kw_only=True, tag="robot.died"):
    """A robot's token has gone, and it has said nothing for the grace time, before the run was over."""

    robot: RobotId
    silent_since_s: Annotated[Seconds, Meta(description="basis of the last order that was heard from it")]


class RobotRestarted(_Record, frozen=True, kw_only=True, tag="robot.restarted"):
    """A robot's token has come that bears another incarnation: a new process has taken its place."""

    robot: RobotId


class RobotReturned(_Record, frozen=True, kw_only=True, tag="robot.returned"):
    """A robot that was taken for dead is there again, in the same process: it was frozen, or cut off."""

    robot: RobotId


class OrderAccepted(_Record, frozen=True, kw_only=True, tag="order.accepted"):
    """A body has taken a new drive order."""

    robot: RobotId
    number: Count
    epoch: Count
    step: Annotated[
        Count, Meta(description="the leader's switching step; 0 for one that follows, or joins in epoch 0")
    ]
    x_m: Metres
    y_m: Metres
    target: Annotated[Point | None, Meta(description="null: stand still")]
    reach_m: Annotated[Length, Meta(description="arc length of the target along the strand's path")]


class OrderRefused(_Record, frozen=True, kw_only=True, tag="order.refused"):
    """A body has not taken an order: it is void, or the drive cannot do it."""

    robot: RobotId
    number: Count
    reason: Text


class OrderFinished(_Record, frozen=True, kw_only=True, tag="order.finished"):
    """A body has driven an order to its end."""

    robot: RobotId
    number: Count
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(description="least clearance while driving it, or the whole step; null: no obstacle"),
    ]


class StepAbandoned(_Record, frozen=True, kw_only=True, tag="step.abandoned"):
    """The leader has stopped short of a step's end, because an obstacle came into its way."""

    step: Count
    epoch: Count
    x_m: Metres
    y_m: Metres


class StepFinished(_Record, frozen=True, kw_only=True, tag="step.finished"):
    """The leader's body stands at the end of a switching step."""

    robot: RobotId
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(
            description="least clearance in the whole step, to hold against the promised; null: no obstacle"
        ),
    ]


class BodyStopped(_Record, frozen=True, kw_only=True, tag="body.stopped"):
    """The dead-man stop: its robot has been silent too long."""

    robot: RobotId


class PoseSampled(_Record, frozen=True, kw_only=True, tag="pose.sampled"):
    """A body's true pose; between two samples of a body it moved straight."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians


class ScanServed(_Record, frozen=True, kw_only=True, tag="scan.served"):
    """A body's sensor has been read, because its robot asked."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians
    revolutions: Annotated[Count, Meta(description="of the scanner, interlaced: rays beside rays")]
    hits: Count


class PromiseBroken(_Record, frozen=True, kw_only=True, tag="promise.broken"):
    """An invariant does not hold, judged from true poses or from what was said; docs/verdict.md names them."""

    invariant: Annotated[str, Meta(pattern="^(S[1-3]|P[1-6])$")]
    robot: RobotId
    other: Annotated[RobotId | None, Meta(description="the other robot of S2, P1 and P3")] = None
    measured_m: Annotated[Metres | None, Meta(description="null: what broke has no length")] = None
    required_m: Metres | None = None
    why: Text


class MessageRefused(_Record, frozen=True, kw_only=True, tag="message.refused"):
    """A message broke the protocol and was dropped."""

    key: Annotated[Text, Meta(description="without the run's root")]
    reason: Text


class FaultInjected(_Record, frozen=True, kw_only=True, tag="fault.injected"):
    """A fault plan has struck: a message, noted by its receiver, or a process."""

    fault: Annotated[Text, Meta(description="`drop`, `delay`, ..., as in the plan; `start` ends a restart")]
    rule: Annotated[Text, Meta(description="the rule's name")]
    key: Annotated[Text | None, Meta(description="of the message, without the run's root")] = None
    number: Annotated[
        Count | None,
        Meta(description="of the message on that key; an answer's, or a query's, is the receiver's count"),
    ] = None
    process: Annotated[Text | None, Meta(description="which was struck: `r3`, `world`, `router`")] = None


class RouterLost(_Record, frozen=True, kw_only=True, tag="router.lost"):
    """The router that carried the world is no more there: nobody can be heard."""


class RouterFound(_Record, frozen=True, kw_only=True, tag="router.found"):
    """A router carries the world again, the same one or another."""

    away_s: Annotated[Seconds, Meta(description="wall clock: for how long there was none")]


class WorldResumed(_Record, frozen=True, kw_only=True, tag="world.resumed"):
    """A world whose process was killed goes on from its own timeline: bodies stand where that saw them last.

    What chance does to drives and scans comes from new streams, which bear the number of the life.
    """

    life: Annotated[Count, Meta(description="1: the first time")]
    entries: Annotated[Count, Meta(description="that it found, of all sources")]
    torn_bytes: Annotated[Count, Meta(description="of a last line that was not whole; it is cut off")]


class RunEnded(_Record, frozen=True, kw_only=True, tag="run.ended"):
    """The world has ended the run."""

    reason: Text


# --- what robots record ---------------------------------------------------------------------------


class RobotStarted(_Record, frozen=True, kw_only=True, tag="robot.started"):
    """A robot's process has its mission and begins."""

    pid: Count
    incarnation: Annotated[Text, Meta(description="as in its liveliness token")] = ""


class RobotFailed(_Record, frozen=True, kw_only=True, tag="robot.failed"):
    """A robot's core has raised an exception, which it never should: the process ends."""

    reason: Text


class StrandFormed(_Record, frozen=True, kw_only=True, tag="strand.formed"):
    """The robot takes its place in the strand."""

    epoch: Count
    sensed: Annotated[bool, Meta(description="whether it took a scan for the order of the strand")]
    order: Annotated[tuple[RobotId, ...], Meta(min_length=1, description="leader first")]
    path_length_m: Annotated[Length, Meta(description="arc length of the leader's start; the tail's is 0")]
    laid: Annotated[
        tuple[Point, ...],
        Meta(
            max_length=2000,
            description="of the leader, where the path is bent between robots: its corners, tail first",
        ),
    ] = ()


class StrandReversed(_Record, frozen=True, kw_only=True, tag="strand.reversed"):
    """The robot that leads has the strand turn round: from the next epoch on the other end leads.

    Arc lengths are of the epoch that ends.
    """

    epoch: Annotated[Count, Meta(description="that ends")]
    cut_m: Annotated[Length, Meta(description="where the new path ends")]
    end_m: Annotated[Length, Meta(description="where the new path begins: where the robot stands that led")]
    back_by_m: Annotated[
        Length,
        Meta(description="how far the new tail wants to come back; 0: the new leader plans on its own"),
    ]


class StrandDissolved(_Record, frozen=True, kw_only=True, tag="strand.dissolved"):
    """The robot that leads has the strand dissolve: a robot's way is blocked, and stays so.

    In the next epoch all line up again, from where they stand; the strand that then forms has the one after.
    """

    epoch: Annotated[Count, Meta(description="that ends")]
    blocked: Annotated[RobotId, Meta(description="the robot whose way is blocked")]


class RobotPlaced(_Record, frozen=True, kw_only=True, tag="robot.placed"):
    """A robot that was not in place at the start has joined: it stands at the strand's end."""

    rank: Annotated[Count, Meta(description="its place in the strand; the leader's is 0")]
    turn: Annotated[Count, Meta(description="in which it joined, alone")]
    x_m: Metres
    y_m: Metres


class RobotBlocked(_Record, frozen=True, kw_only=True, tag="robot.blocked"):
    """A robot that had its turn to join found no way: it stands, and others have theirs first."""

    turn: Count
    reason: Text
    x_m: Metres
    y_m: Metres


class SeenObstacle(Struct, frozen=True, kw_only=True):
    """An obstacle as seen: its tangent points, clockwise first, and the chord between them."""

    tangent_1: Point
    tangent_2: Point
    chord_m: Length


class SeenGap(Struct, frozen=True, kw_only=True):
    """The opening between two obstacles that are neighbours anti-clockwise."""

    right: Annotated[Count, Meta(description="index of the obstacle on its right in `obstacles`")]
    left: Count
    width_m: Length
    delta_rad: Annotated[float, Meta(ge=0.0, le=6.3, description="angle seen from the switching position")]
    passable: bool


class StepPlanned(_Record, frozen=True, kw_only=True, tag="step.planned"):
    """The leader has planned a switching step, from one scan; or a robot that joins."""

    step: Count
    epoch: Annotated[Count, Meta(description="of the strand, or of the lining up before it has formed")]
    law: Law
    x_m: Metres
    y_m: Metres
    obstacles: Annotated[
        tuple[SeenObstacle, ...], Meta(max_length=250, description="anti-clockwise; at most 250 are told")
    ]
    gaps: Annotated[tuple[SeenGap, ...], Meta(max_length=250)]
    gap: Annotated[
        Count | None, Meta(description="index of the gap chosen in `gaps`; null: no gap was aimed at")
    ]
    heading_rad: Radians
    length_m: Length
    target: Point
    reach_m: Annotated[Length, Meta(description="arc length of the target along the strand's path")]
    promised_clearance_m: Annotated[Length | None, Meta(description="null: this law promises none")]
    cost_to_go_m: Annotated[Length | None, Meta(description="from the target to the goal; null: no goal")]


class SegmentChecked(_Record, frozen=True, kw_only=True, tag="segment.checked"):
    """A robot that follows has checked its next segment of the path against its own scan."""

    target: Point
    clear: bool
    clearance_m: Annotated[Metres, Meta(description="of the swept hull, to the nearest hit that is no robot")]


class AuthorityGranted(_Record, frozen=True, kw_only=True, tag="authority.granted"):
    """A robot lets the one behind it drive up to this arc length of its path."""

    to: RobotId
    epoch: Count
    authority_m: Length


class LinkSilent(_Record, frozen=True, kw_only=True, tag="link.silent"):
    """A neighbour has not been heard for `silence_s`: the robot stands until it is."""

    neighbour: RobotId
    silent_s: Seconds


class LinkHeard(_Record, frozen=True, kw_only=True, tag="link.heard"):
    """A silent neighbour has been heard again."""

    neighbour: RobotId


class LinkBroken(_Record, frozen=True, kw_only=True, tag="link.broken"):
    """A robot has given a link up, and has left the strand: docs/strand.md, Healing."""

    neighbour: RobotId
    cause: Annotated[str, Meta(description="`token`: it shows none any more; `silence`: it does")]
    silent_s: Seconds


class MusterCalled(_Record, frozen=True, kw_only=True, tag="muster.called"):
    """A robot has called all members to line up again."""

    epoch: Count
    members: Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]
    why: Text


class MusterJoined(_Record, frozen=True, kw_only=True, tag="muster.joined"):
    """A robot has left whatever it was in for a muster that was called."""

    epoch: Count


class LeaderSucceeded(_Record, frozen=True, kw_only=True, tag="leader.succeeded"):
    """A robot leads now that did not lead the strand before."""

    epoch: Count
    before: Annotated[RobotId | None, Meta(description="who led as far as it knows")]


class StrandHealed(_Record, frozen=True, kw_only=True, tag="strand.healed"):
    """The leader of a strand that was called has heard the robot behind it, and may go on."""

    epoch: Count
    members: Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class RobotHeld(_Record, frozen=True, kw_only=True, tag="robot.held"):
    """A robot that might drive on waits for the one behind it: the stretch rule."""

    behind_m: Annotated[Length, Meta(description="how far it is behind what it has been granted")]


class RobotReleased(_Record, frozen=True, kw_only=True, tag="robot.released"):
    """The wait is over."""


class GoalReached(_Record, frozen=True, kw_only=True, tag="goal.reached"):
    """The leader stands within the goal's tolerance; without a goal, at its last switching position."""

    x_m: Metres
    y_m: Metres


class RobotArrived(_Record, frozen=True, kw_only=True, tag="robot.arrived"):
    """A robot stands at its place behind the one ahead, which has arrived; or it leads."""

    progress_m: Length


class RouteLost(_Record, frozen=True, kw_only=True, tag="route.lost"):
    """The leader knows no way on: it stands, and the run ends."""

    reason: Text


class TrafficCounted(_Record, frozen=True, kw_only=True, tag="traffic.counted"):
    """A source's messages by key (without the run's root): sent, received, the newest number that came."""

    sent: Counts
    received: Counts
    newest: Counts
    injected: Annotated[
        dict[Annotated[str, Meta(max_length=40)], Counts],
        Meta(max_length=40, description="by fault, what a fault plan took away, by key: it was not received"),
    ] = {}
    refused: Annotated[Counts, Meta(description="by key, what broke the protocol and was dropped")]
    overflowed: Annotated[Count, Meta(description="arrivals that its full inbox dropped")]
    unrecorded: Annotated[Count, Meta(description="entries of its own that its full outbox did not take")]


class RobotSettled(_Record, frozen=True, kw_only=True, tag="robot.settled"):
    """A robot has heard that the run is over and sends no more; `sent` is final."""

    sent: Counts


Record = (
    RobotAppeared
    | RobotDied
    | RobotRestarted
    | RobotReturned
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
    | StrandReversed
    | StrandDissolved
    | RobotPlaced
    | RobotBlocked
    | StepPlanned
    | SegmentChecked
    | AuthorityGranted
    | LinkSilent
    | LinkHeard
    | LinkBroken
    | MusterCalled
    | MusterJoined
    | LeaderSucceeded
    | StrandHealed
    | RobotHeld
    | RobotReleased
    | GoalReached
    | RobotArrived
    | RouteLost
    | TrafficCounted
    | RobotSettled
)


class Entry(Struct, frozen=True, kw_only=True):
    """One entry of the timeline: when, and what happened. Its source stands in the key that it came by."""

    n: Annotated[Count, Meta(description="the source's own count, from 1")]
    t_s: Annotated[Seconds, Meta(description="simulated time")]
    hlc: Annotated[str, Meta(max_length=80, description="hybrid logical clock of the source")]
    record: Record
