"""Every message of the fleet, as frozen types with bounds.

Rule 1: a link message is the sender's whole link state, so that any one that arrives is enough.
Rule 2: who sent a message stands in its key, never in the message.
"""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.faults.rules import Name, Rule
from protocol.frames import ROBOTS_MAX, Count, Length, Point, Pose, RobotId, Seconds, Speed, Vertex
from protocol.mission import Mission
from protocol.timeline import Entry

RAYS_MAX = 7200  # of one scan: 58 kB on the wire
REVOLUTIONS_MAX = 900  # as many as there can be, of the fewest directions
FORMERS_MAX = 3  # as often may a strand heal before it has moved
LEG_CORNERS_MAX = 64  # a leg with more is looked at anew
SEEN_BYTES_MAX = 32_768  # half of what a message may be long
Incarnation = Annotated[str, Meta(max_length=64)]  # a chunk of the key of its token
Lineage = Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class Phase(StrEnum):
    """How far the run is; a run only ever goes forward through these."""

    RUNNING = "running"
    OVER = "over"  # drive and say no more; tell the recorder what was sent
    CLOSING = "closing"  # everything sent has arrived: tell the recorder what was received, and go

    def later(self, other: "Phase") -> "Phase":
        """The one of the two that a run comes to last."""
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
"""What goes to all robots."""


class Handover(Struct, frozen=True, kw_only=True):
    """What a leader knows that its successor needs."""

    number: Count
    """Counts what leaders hand on; the newest is valid."""
    steps: Count
    """Switching steps planned by now."""
    dissolved: Count
    """How often a strand has dissolved by now."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """What guidance remembers."""


class Reversal(Struct, frozen=True, kw_only=True):
    """The strand's other end is to lead in the next epoch, along the path that there is, the other way.

    Arc lengths are the old epoch's: the new one counts from `end_m` down to `cut_m`.
    """

    cut_m: Length
    """Where the new path ends: 0, or where the robot stands that is to lead."""
    end_m: Length
    """Where the robot stands that leads now."""
    back_by_m: Length
    """How far the new tail wants to come back along the new path; 0: the new leader plans on its own."""
    turns: Count
    """How many there have been by now with no step towards the goal between them."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """What the old leader's guidance remembers."""


class Dissolution(Struct, frozen=True, kw_only=True):
    """The strand dissolves: when all stand, they line up again from where they are."""

    times: Count
    """How often that has happened by now, this time included."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """What the old leader's guidance remembers."""


class AheadState(Struct, frozen=True, kw_only=True, tag="ahead"):
    """What a robot tells the one behind it."""

    epoch: Count
    t_s: Seconds = 0.0
    """When it was said, by the sender's clock."""
    echo_s: Seconds = 0.0
    """The newest such time that was heard from the robot behind."""
    path_from: Count
    """Index of the first vertex told; those before it have been acknowledged."""
    path: Annotated[tuple[Vertex, ...], Meta(max_length=512)]
    progress_m: Length
    authority_m: Length
    """How far along this path the robot behind may drive."""
    pose: Pose
    arrived: bool
    """Whether the path ends here for good."""
    lineage: Lineage
    """Who stands ahead, nearest first, up to the leader."""
    vertices: Count
    """How many the path has by now."""
    backs_up: bool
    """Whether the first robot only makes way for the tail, which wants to come back along the path."""
    reversal: Reversal | None
    """All robots ahead stand, and wait for the strand to turn round."""
    dissolution: Dissolution | None = None
    """All robots ahead stand, and wait for the strand to dissolve."""
    handed: Handover | None = None
    """What the robot behind has not acknowledged of what the leader hands on."""


class BehindState(Struct, frozen=True, kw_only=True, tag="behind"):
    """What a robot tells the one ahead of it."""

    epoch: Count
    t_s: Seconds = 0.0
    """When it was said, by the sender's clock."""
    echo_s: Seconds = 0.0
    """The newest such time that was heard from the robot ahead."""
    handed: Count = 0
    """Number of the newest handover that it has: the acknowledgement."""
    vertices: Count
    """How many vertices of the path ahead are known: the acknowledgement."""
    progress_m: Length
    tail_progress_m: Length
    stand: bool
    """Whether it and all robots behind it stand, as far as is known."""
    pose: Pose
    blocked: RobotId | None = None
    """Which robot, it or one behind it, has found its way blocked for too long."""


class Drive(Struct, frozen=True, kw_only=True, tag="drive"):
    """A robot's newest drive order: turn towards the target on the spot, drive straight to it, stop.

    Repeating an order changes nothing. No target means stand still.
    """

    number: Count
    basis_s: Seconds
    """Time of the odometry that the robot knew when it sent this: shows that it is awake."""
    target: Point | None
    speed_mps: Speed
    epoch: Count
    step: Count
    """The leader's switching step that this drives; 0 for a robot that follows, or joins."""
    reach_m: Length
    """Arc length of the target along the strand's path: what the authority has to cover."""
    until_s: Seconds | None = None
    """The body drives until then at most, unless it hears a later time with the same order; None: no limit.

    Where obstacles move, this is how long the robot's newest scan is good for.
    """


class Odometry(Struct, frozen=True, kw_only=True, tag="odometry"):
    """What a body tells its robot, many times a second; it is also the robot's clock."""

    t_s: Seconds
    pose: Pose
    moving: bool
    finished: Count
    """Number of the newest drive order that has been driven to its end."""
    ordered: Count = 0
    """Number of the newest drive order that the body has taken: where one that is restarted goes on."""
    phase: Phase


class Scan(Struct, frozen=True, kw_only=True, tag="scan"):
    """Ranges in evenly spread directions, anti-clockwise from -pi [m; world frame].

    Where there is no hit stands the range limit. The scanner's index is held to the world's x axis, so a
    scan does not depend on which way the body faces.
    """

    t_s: Seconds
    pose: Pose
    ranges_m: Annotated[tuple[Length, ...], Meta(min_length=8, max_length=RAYS_MAX)]


class LogBatch(Struct, frozen=True, kw_only=True, tag="log"):
    """Timeline entries of one source, consecutive in their numbers."""

    incarnation: Incarnation = ""
    """Of the source: one that is started again counts from 1 again."""
    entries: Annotated[tuple[Entry, ...], Meta(max_length=256)]


class Logged(Struct, frozen=True, kw_only=True, tag="logged"):
    """The recorder has written every entry of this source, in this incarnation, up to this number."""

    incarnation: Incarnation = ""
    up_to: Count


class Faults(Struct, frozen=True, kw_only=True, tag="faults"):
    """What is to go wrong at a robot beside the fault plan that it has read; the newest is valid."""

    number: Count
    step: Count
    """The newest switching step that has been planned: rules of a plan may hold from one on."""
    struck: Annotated[tuple[Name, ...], Meta(max_length=1000)]
    """The rules for processes that have struck: each does so once, whatever is started again."""
    rules: Annotated[tuple[Rule, ...], Meta(max_length=100)]
    """Rules for messages that were given while the run went on."""
    slow_s: Seconds
    """How long the robot is to take each time that it looks at what has arrived; 0: as ever."""


class ScanQuery(Struct, frozen=True, kw_only=True, tag="scan_query"):
    """A query for a scan of one revolution or more.

    Between two revolutions the scanner is turned by an equal share of its ray spacing, so that their rays
    interlace: n revolutions of k directions are a scan of n k directions.
    """

    revolutions: Annotated[int, Meta(ge=1, le=REVOLUTIONS_MAX)]


class Ask(Struct, frozen=True, kw_only=True, tag="ask"):
    """A query that needs no words: its key says what is asked for."""


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
