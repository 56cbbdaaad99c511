"""All messages of the fleet, as frozen types with bounds.

Rule 1: a link message is the sender's whole link state, so any one that arrives is enough.
Rule 2: the sender of a message is named by its key, never in the message.
Rule 3: messages, entries and the events that carry them are in no reference cycle. So the collector need not
        search them (`gc=False`): a rehearsal keeps all its entries.
"""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.faults.rules import GIVEN_MAX, RULES_MAX, Name, Rule
from protocol.fence import Bearing, Epoch, Fence, Life, Raise, Turn
from protocol.frames import Count, Length, Point, Pose, Seconds, Speed, Vertex
from protocol.mission import DIRECTIONS_MIN, RAYS_MAX, REVOLUTIONS_MAX, Mission
from protocol.timeline import Entry
from protocol.wire.view import SEEN_BYTES_MAX, Answer, Formation, Plea, Report

BATCH_ENTRIES_MAX = 256  # of a `LogBatch`
LATE_S_MAX = 3.0  # wall: with a share of 1 % of a core, turns of a process were late by up to 2 s
Late = Annotated[float, Meta(ge=0.0, le=LATE_S_MAX)]
Incarnation = Annotated[str, Meta(max_length=64)]  # a chunk of the key of its token


class Phase(StrEnum):
    """The phases of a run, in order; a run never goes back."""

    RUNNING = "running"
    OVER = "over"  # robots stop driving and sending; they record what they sent
    CLOSING = "closing"  # everything sent has arrived: robots record what they received, and end

    def later(self, other: "Phase") -> "Phase":
        """The later one of two phases."""
        return self if other is self else max(self, other, key=list(Phase).index)


class Handover(Struct, frozen=True, gc=False, kw_only=True):
    """The knowledge of a leader that its successor needs."""

    number: Count
    """Counts the handovers of leaders; the newest is valid."""
    steps: Count
    """Switching steps planned so far."""
    seen: Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
    """The memory of guidance."""


class AheadState(Struct, frozen=True, gc=False, kw_only=True, tag="ahead"):
    """The link state that a robot sends to the robot behind it."""

    epoch: Epoch
    life: Life
    """Of the sender."""
    t_s: Seconds
    """When it was sent, by the sender's clock."""
    path_from: Count
    """Index of the first vertex in `path`; earlier vertices have been acknowledged."""
    path: Annotated[tuple[Vertex, ...], Meta(max_length=512)]
    progress_m: Length
    authority_m: Length
    """How far along this path the robot behind may drive."""
    arrived: bool
    """Whether the path ends here for good."""
    vertices: Count
    """The number of vertices of the whole path."""
    backs_up: bool
    """Whether the first robot only makes way for the tail, which wants to return along the path."""
    handed: Handover | None = None
    """The leader's handover, until the robot behind has acknowledged it."""


class BehindState(Struct, frozen=True, gc=False, kw_only=True, tag="behind"):
    """The link state that a robot sends to the robot ahead of it."""

    epoch: Epoch
    life: Life
    """Of the sender."""
    t_s: Seconds
    """When it was sent, by the sender's clock."""
    handed: Count = 0
    """Acknowledgement: the number of the newest handover received."""
    vertices: Count
    """Acknowledgement: the number of known vertices of the path ahead."""
    progress_m: Length
    tail_progress_m: Length
    stand: bool
    """Whether this robot and, as far as it knows, all robots behind it stand."""


class Drive(Struct, frozen=True, gc=False, kw_only=True, omit_defaults=True, tag="drive"):
    """A robot's newest drive order: turn towards the target on the spot, drive straight to it, stop.

    Repeating an order changes nothing. No target means stand still.
    """

    number: Count
    basis_s: Seconds
    """Time of the newest odometry at the sender: it shows that the robot is awake."""
    target: Point | None
    speed_mps: Speed
    bearing: Bearing
    """The fence under which the order was given; an order to stand needs none."""
    step: Count
    """The leader's switching step; 0 for a robot that follows or joins."""
    reach_m: Length
    """Arc length of the target along the strand's path; the authority has to cover it."""
    until_s: Seconds | None = None
    """The body stops at this time, unless a repetition of the order extends it; None: no limit.

    Where obstacles move, the robot's newest scan is valid until then.
    """
    late_s: Late = 0.0
    """How late the robot's process runs, by its own measurement [wall s]; its shell fills it in."""


class Odometry(Struct, frozen=True, gc=False, kw_only=True, tag="odometry"):
    """The state of a body, sent to its robot many times a second; it is also the robot's clock."""

    n: Count
    """Counts the odometry of this body; the newest by fence, then by number, is valid."""
    t_s: Seconds
    pose: Pose
    moving: bool
    finished: Count
    """Number of the newest drive order that is finished."""
    ordered: Count = 0
    """Number of the newest drive order that the body accepted; a restarted robot continues from it."""
    fence: Fence
    stood_s: Seconds = 0.0
    """For how long every body of the fleet has stood."""
    phase: Phase


class Scan(Struct, frozen=True, gc=False, kw_only=True, tag="scan"):
    """Ranges in evenly spaced directions, anti-clockwise from -pi [m; world frame].

    A ray without a hit has the range limit. Directions refer to the world's x axis, so a scan does not depend
    on the heading of the body.
    """

    t_s: Seconds
    pose: Pose
    fence: Fence
    """The fence when it was taken."""
    ranges_m: Annotated[tuple[Length, ...], Meta(min_length=DIRECTIONS_MIN, max_length=RAYS_MAX)]


class LogBatch(Struct, frozen=True, gc=False, kw_only=True, tag="log"):
    """Timeline entries of one source, with consecutive numbers."""

    incarnation: Incarnation = ""
    """The incarnation of the source: a restarted source counts from 1 again."""
    entries: Annotated[tuple[Entry, ...], Meta(max_length=BATCH_ENTRIES_MAX)]


class Logged(Struct, frozen=True, gc=False, kw_only=True, tag="logged"):
    """Acknowledgement: the recorder has written all entries of this incarnation up to this number."""

    incarnation: Incarnation = ""
    up_to: Count


class Faults(Struct, frozen=True, gc=False, kw_only=True, tag="faults"):
    """The faults of a robot beyond the fault plan that it has read; the newest message is valid."""

    number: Count
    step: Count
    """The newest planned switching step, since rules of a plan can depend on it."""
    struck: Annotated[tuple[Name, ...], Meta(max_length=RULES_MAX)]
    """The process rules that have struck: each strikes once, even after a restart."""
    rules: Annotated[tuple[Rule, ...], Meta(max_length=GIVEN_MAX)]
    """Manual rules for messages."""
    slow_s: Seconds
    """Additional delay of each read of the robot's inbox; 0: none."""


class ScanQuery(Struct, frozen=True, gc=False, kw_only=True, tag="scan_query"):
    """A query for a scan of one revolution or more.

    Between revolutions the scanner turns by an equal share of its ray spacing, so that the rays interlace:
    n revolutions of k directions give a scan of n k directions.
    """

    revolutions: Annotated[int, Meta(ge=1, le=REVOLUTIONS_MAX)]


class Ask(Struct, frozen=True, gc=False, kw_only=True, tag="ask"):
    """A query without parameters: its key says what is requested."""


Message = (
    Report
    | Answer
    | Formation
    | Plea
    | Raise
    | Turn
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
