"""All messages of the fleet, as frozen types with bounds.

Rule 1: a link message is the sender's whole link state, so any one that arrives is enough.
Rule 2: the sender of a message is named by its key, never in the message.
"""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.faults.rules import Name, Rule
from protocol.frames import ROBOTS_MAX, Count, Length, Point, Pose, RobotId, Seconds, Speed, Vertex
from protocol.mission import Mission
from protocol.timeline import Entry

RAYS_MAX = 7200  # per scan: 58 kB on the wire
REVOLUTIONS_MAX = 900  # the maximum for the smallest number of directions
FORMERS_MAX = 3  # how often a strand may heal before it has moved
LEG_CORNERS_MAX = 64  # a leg with more corners is planned anew
SEEN_BYTES_MAX = 32_768  # half of the size limit of a message
Incarnation = Annotated[str, Meta(max_length=64)]  # a chunk of the key of its token
Lineage = Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class Phase(StrEnum):
    """The phases of a run, in order; a run never goes back."""

    RUNNING = "running"
    OVER = "over"  # robots stop driving and sending; they record what they sent
    CLOSING = "closing"  # everything sent has arrived: robots record what they received, and end

    def later(self, other: "Phase") -> "Phase":
        """The later one of two phases."""
        return self if other is self else max(self, other, key=list(Phase).index)


class Turn(Struct, frozen=True, kw_only=True):
    """The right to join the strand, alone; docs/strand.md, Lining up."""

    number: Count
    robot: RobotId


class Former(Struct, frozen=True, kw_only=True):
    """The place that a robot had in a strand, and has not left since."""

    epoch: Count
    rank: Count
    """The leader's is 0."""
    progress_m: Length


class Attempt(Struct, frozen=True, kw_only=True):
    """An order in which the members of a muster are to line up, by those that were tried in vain."""

    trial: bool = True
    """Whether one may be tried at first for which nobody has to move."""
    led: Lineage = ()
    """Who has led in vain, the first first."""


FIRST_ATTEMPT = Attempt()


class Muster(Struct, frozen=True, kw_only=True, tag="muster"):
    """A robot's announcement, to all: where it stands, what it sees, and how far the lining up is."""

    number: Count
    """Counts what this robot announces; the newest is valid."""
    epoch: Count = 0
    """Of this lining up: 0 at first, and one more than that of a strand that has dissolved."""
    pose: Pose
    """Where it stands; while it has the turn, where it stood when it was given."""
    obstacle_m: Length | None = None
    """Distance to the nearest hit of its own scan that is no robot; the range limit where there is none.

    None until the places of all robots are known, and where there is a goal, since then it is not needed.
    """
    leg_clear: bool | None = None
    """Whether the straight way to the robot ahead of it in the order of the start is; None until it knows."""
    turn: Count = 0
    """The newest turn that it knows of, in which it stands, or moves if it is its own."""
    gives: Turn | None = None
    """The newest turn that it gave."""
    ended: Count = 0
    """The newest turn of its own that is over."""
    rank: Count | None = None
    """Its place in the strand, if it came there by a turn; the leader's is 0."""
    order: Lineage = ()
    """The strand, leader first; empty until all are in place as far as it knows."""
    members: Lineage = ()
    """Who lines up; empty: all robots of the mission."""
    attempt: Attempt = FIRST_ATTEMPT
    """Which orders of these members have been tried in vain."""
    made_m: Length = 0.0
    """How far it has driven in this lining up: whether it makes something of its turn."""
    formers: Annotated[tuple[Former, ...], Meta(max_length=FORMERS_MAX)] = ()
    """Its places in the strands that it was in last, newest first, as far as it has not left them."""
    leg: Annotated[tuple[Point, ...], Meta(max_length=LEG_CORNERS_MAX)] = ()
    """Corners of its way to the robot ahead, from its own place on, where that is not straight."""
    hears: Lineage = ()
    """Which members it has heard, where some have been left out; docs/strand.md, Healing."""
    free_s: Seconds | None = None
    """When all robots that are left out stand, as far as it knows; None until all members are bound."""
    t_s: Seconds = 0.0
    """When it was said, by the sender's clock."""
    echo_s: Seconds = 0.0
    """The newest such time that was heard from the robot that has the turn."""


class Beacon(Struct, frozen=True, kw_only=True, tag="beacon"):
    """The leader of a strand says, to all, which epoch it leads."""

    epoch: Count
    t_s: Seconds


class Plea(Struct, frozen=True, kw_only=True, tag="plea"):
    """A robot that is in no strand has heard a beacon, and asks to be called."""

    epoch: Count
    """The beacon's."""
    t_s: Seconds


Announcement = Muster | Beacon | Plea
"""The messages that go to all robots."""


class Handover(Struct, frozen=True, kw_only=True):
    """The knowledge of a leader that its successor needs."""

    number: Count
    """Counts the handovers of leaders; the newest is valid."""
    steps: Count
    """Switching steps planned so far."""
    dissolved: Count
    """How often a strand has dissolved so far."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """The memory of guidance."""


class Reversal(Struct, frozen=True, kw_only=True):
    """The strand reverses: in the next epoch its other end leads, back along the known path.

    Arc lengths refer to the old epoch: the new one counts from `end_m` down to `cut_m`.
    """

    cut_m: Length
    """Where the new path ends: 0, or the position of the new leader."""
    end_m: Length
    """The position of the present leader."""
    back_by_m: Length
    """How far the new tail wants to return along the new path; 0: the new leader plans on its own."""
    turns: Count
    """The number of reversals since the last step towards the goal."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """The memory of the old leader's guidance."""


class Dissolution(Struct, frozen=True, kw_only=True):
    """The strand dissolves: when all robots stand, they line up again from their positions."""

    times: Count
    """How often that has happened so far, including this time."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """The memory of the old leader's guidance."""


class AheadState(Struct, frozen=True, kw_only=True, tag="ahead"):
    """The link state that a robot sends to the robot behind it."""

    epoch: Count
    t_s: Seconds = 0.0
    """When it was sent, by the sender's clock."""
    echo_s: Seconds = 0.0
    """The newest such time stamp heard from the robot behind."""
    path_from: Count
    """Index of the first vertex in `path`; earlier vertices have been acknowledged."""
    path: Annotated[tuple[Vertex, ...], Meta(max_length=512)]
    progress_m: Length
    authority_m: Length
    """How far along this path the robot behind may drive."""
    pose: Pose
    arrived: bool
    """Whether the path ends here for good."""
    lineage: Lineage
    """The robots ahead, nearest first, up to the leader."""
    vertices: Count
    """The number of vertices of the whole path."""
    backs_up: bool
    """Whether the first robot only makes way for the tail, which wants to return along the path."""
    reversal: Reversal | None
    """All robots ahead stand and wait for the strand to reverse."""
    dissolution: Dissolution | None = None
    """All robots ahead stand and wait for the strand to dissolve."""
    handed: Handover | None = None
    """The leader's handover, until the robot behind has acknowledged it."""


class BehindState(Struct, frozen=True, kw_only=True, tag="behind"):
    """The link state that a robot sends to the robot ahead of it."""

    epoch: Count
    t_s: Seconds = 0.0
    """When it was sent, by the sender's clock."""
    echo_s: Seconds = 0.0
    """The newest such time stamp heard from the robot ahead."""
    handed: Count = 0
    """Acknowledgement: the number of the newest handover received."""
    vertices: Count
    """Acknowledgement: the number of known vertices of the path ahead."""
    progress_m: Length
    tail_progress_m: Length
    stand: bool
    """Whether this robot and, as far as it knows, all robots behind it stand."""
    pose: Pose
    blocked: RobotId | None = None
    """The robot, this one or one behind it, whose way has been blocked for too long."""


class Drive(Struct, frozen=True, kw_only=True, tag="drive"):
    """A robot's newest drive order: turn towards the target on the spot, drive straight to it, stop.

    Repeating an order changes nothing. No target means stand still.
    """

    number: Count
    basis_s: Seconds
    """Time of the newest odometry at the sender: it shows that the robot is awake."""
    target: Point | None
    speed_mps: Speed
    epoch: Count
    step: Count
    """The leader's switching step; 0 for a robot that follows or joins."""
    reach_m: Length
    """Arc length of the target along the strand's path; the authority has to cover it."""
    until_s: Seconds | None = None
    """The body stops at this time, unless a repetition of the order extends it; None: no limit.

    Where obstacles move, the robot's newest scan is valid until then.
    """


class Odometry(Struct, frozen=True, kw_only=True, tag="odometry"):
    """The state of a body, sent to its robot many times a second; it is also the robot's clock."""

    t_s: Seconds
    pose: Pose
    moving: bool
    finished: Count
    """Number of the newest drive order that is finished."""
    ordered: Count = 0
    """Number of the newest drive order that the body accepted; a restarted robot continues from it."""
    phase: Phase


class Scan(Struct, frozen=True, kw_only=True, tag="scan"):
    """Ranges in evenly spaced directions, anti-clockwise from -pi [m; world frame].

    A ray without a hit has the range limit. Directions refer to the world's x axis, so a scan does not depend
    on the heading of the body.
    """

    t_s: Seconds
    pose: Pose
    ranges_m: Annotated[tuple[Length, ...], Meta(min_length=8, max_length=RAYS_MAX)]


class LogBatch(Struct, frozen=True, kw_only=True, tag="log"):
    """Timeline entries of one source, with consecutive numbers."""

    incarnation: Incarnation = ""
    """The incarnation of the source: a restarted source counts from 1 again."""
    entries: Annotated[tuple[Entry, ...], Meta(max_length=256)]


class Logged(Struct, frozen=True, kw_only=True, tag="logged"):
    """Acknowledgement: the recorder has written all entries of this incarnation up to this number."""

    incarnation: Incarnation = ""
    up_to: Count


class Faults(Struct, frozen=True, kw_only=True, tag="faults"):
    """The faults of a robot beyond the fault plan that it has read; the newest message is valid."""

    number: Count
    step: Count
    """The newest planned switching step, since rules of a plan can depend on it."""
    struck: Annotated[tuple[Name, ...], Meta(max_length=1000)]
    """The process rules that have struck: each strikes once, even after a restart."""
    rules: Annotated[tuple[Rule, ...], Meta(max_length=100)]
    """Manual rules for messages."""
    slow_s: Seconds
    """Additional delay of each read of the robot's inbox; 0: none."""


class ScanQuery(Struct, frozen=True, kw_only=True, tag="scan_query"):
    """A query for a scan of one revolution or more.

    Between revolutions the scanner turns by an equal share of its ray spacing, so that the rays interlace:
    n revolutions of k directions give a scan of n k directions.
    """

    revolutions: Annotated[int, Meta(ge=1, le=REVOLUTIONS_MAX)]


class Ask(Struct, frozen=True, kw_only=True, tag="ask"):
    """A query without parameters: its key says what is requested."""


Message = (
    Muster
    | Beacon
    | Plea
    | AheadState
    | BehindState
    | Drive
    | Odometry
    | Scan
    | Mission
    | Faults
    | LogBatch
    | Logged
    | Ask
    | ScanQuery
)
