"""The messages of a view, between its coordinator and its robots: `view/{from}/{to}`; docs/strand.md.

Rule 1: a report, an answer and a piece of a formation are each the sender's whole state, so any one that
        arrives is enough.
Rule 2: an epoch has exactly one formation. It is sent in pieces, and sent again byte for byte.
"""

from typing import Annotated

from msgspec import Meta, Struct

from protocol.fence import Epoch, Life
from protocol.frames import ROBOTS_MAX, Count, Length, Point, Pose, RobotCount, RobotId, Vertex

FORMERS_MAX = 4  # the last three formations, and the draft
LEG_CORNERS_MAX = 64  # a leg with more corners is planned anew
PIECE_VERTICES_MAX = 256
SEEN_BYTES_MAX = 32_768  # half of the size limit of a message
STRANDED_MAX = 64  # members are told of no more: the rest are let in again some seconds too early

Seen = Annotated[bytes, Meta(max_length=SEEN_BYTES_MAX)]
Robots = Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class Former(Struct, frozen=True, gc=False, kw_only=True):
    """A place that a robot had and has not left since."""

    epoch: Epoch
    rank: RobotCount
    """The leader's is 0."""
    s_m: Length = 0.0
    """Arc length along that formation's path; of no meaning in a draft."""
    at: Point | None = None
    """Where on that path that is; the body may stand beside it. Null: it is a place in a draft, of which no
    formation has been made."""
    leg_from_m: Length | None = None
    """From here to `s_m` it tells the path's corners, for the robot behind; null: it tells none."""
    corners: Annotated[tuple[Vertex, ...], Meta(max_length=LEG_CORNERS_MAX)] = ()

    @property
    def draft(self) -> bool:
        """Whether it is a place in a draft."""
        return self.at is None


class Counters(Struct, frozen=True, gc=False, kw_only=True):
    """What a fleet counts from one formation to the next."""

    steps: Count = 0
    """Switching steps planned so far."""
    in_vain: Count = 0
    """Attempts in vain since a strand advanced: it turned round, dissolved, or its leader knew no way."""
    last_to_lead: Robots = ()
    """Until a strand advances, these robots lead only after all others, and in this order."""
    heals: Count = 0
    """How often a strand has formed again after a loss."""


class Question(Struct, frozen=True, gc=False, kw_only=True):
    """The coordinator asks a robot to look around, or at its leg: the way to the robot ahead in the draft."""

    number: Count
    """Counts the questions of a view."""
    place: Pose | None = None
    """Where the robot ahead stands; null: the robot is to tell how far off the nearest obstacle is."""
    formers: Annotated[tuple[Former, ...], Meta(max_length=FORMERS_MAX)] = ()
    """That robot's."""
    others: Annotated[tuple[Point, ...], Meta(max_length=64)] = ()
    """Where robots stand that the scan may show."""


class Look(Struct, frozen=True, gc=False, kw_only=True):
    """The answer to a question."""

    number: Count
    clear: bool = False
    """Whether nothing is in the way on its leg."""
    obstacle_m: Length | None = None
    """Distance to the nearest hit that is no robot; null: there is none within the range limit."""
    way: Annotated[tuple[Point, ...], Meta(max_length=LEG_CORNERS_MAX + 2)] = ()
    """The path that the robot ahead has driven, from the robot's own place to the other's, ends included;
    empty: they do not both stand on one path of one epoch."""

    @property
    def driven(self) -> bool:
        """Whether the robot ahead has driven the leg."""
        return len(self.way) > 0


class Report(Struct, frozen=True, gc=False, kw_only=True, tag="report"):
    """A bound robot says where it stands and what it knows, to the coordinator."""

    epoch: Epoch
    life: Life
    number: Count
    """Counts what this robot reports in this view; the newest is valid."""
    turn: Count
    """Of the odometry from which the place was read; all orders of the robot had ended by then."""
    place: Pose
    formers: Annotated[tuple[Former, ...], Meta(max_length=FORMERS_MAX)] = ()
    """Its places in earlier formations and drafts, newest first, as far as it has not left them."""
    look: Look | None = None
    """Its answer to the newest question."""
    ended: Count = 0
    """The newest turn of its own that it has ended."""
    placed: bool = False
    """Whether it ended that turn at a place in the strand."""
    map_number: Count = 0
    """Of the newest map that it has."""
    seen: Seen | None = None
    """That map, where the coordinator has asked for it."""
    arrived: bool = False
    """Whether its former place was its place at the goal."""
    counters: Counters = Counters()
    counted: Epoch = Epoch()
    """The formation that the counters are from."""


class Join(Struct, frozen=True, gc=False, kw_only=True):
    """Where the strand of the draft ends, for the robot that has the turn."""

    turn: Count
    strand: Annotated[tuple[Point, ...], Meta(min_length=1, max_length=ROBOTS_MAX)]
    """Where those in place stand, leader first. Nobody can join a strand of nobody."""
    waiting: Annotated[tuple[Point, ...], Meta(max_length=ROBOTS_MAX)]
    """Where all others stand that have reported, this robot apart."""
    robots: Robots
    """Those in place and those others: where the set changes, maps may show bodies that were not reported."""
    line: Annotated[tuple[Point, ...], Meta(max_length=2 * ROBOTS_MAX)]
    """The way from the leader to the last in place."""
    last_leg: Count
    """How many segments of that are the last robot's own leg."""


class Answer(Struct, frozen=True, gc=False, kw_only=True, tag="answer"):
    """The coordinator's answer to a report, or a leader's to a plea."""

    epoch: Epoch
    life: Life
    """Of the robot that it is for."""
    heard: Count
    """The number of the newest report; 0: this is a leader's answer to a plea."""
    after_turn: Count = 0
    """The last turn that was put for the robot: its place is to be read from an odometry after that."""
    out: bool = False
    """Whether the robot is left out of the formation."""
    question: Question | None = None
    join: Join | None = None
    rank: RobotCount | None = None
    """The robot's place in the draft, if it is in place."""
    wants_map: bool = False


class Neighbour(Struct, frozen=True, gc=False, kw_only=True):
    """A robot beside another in a formation."""

    robot: RobotId
    life: Life
    s_m: Length
    """Where it stands, in arc length along the formation's path."""


class Formation(Struct, frozen=True, gc=False, kw_only=True, tag="formation"):
    """A piece of what a view has agreed on, for one member: the whole path, and its own place."""

    epoch: Epoch
    life: Life
    """Of the member."""
    turn: Count
    """Of the formation's ALL."""
    members: RobotCount
    rank: RobotCount
    """The leader's is 0."""
    s_m: Length
    """The member's place, in arc length along the path."""
    place: Pose
    """The same in the plane."""
    ahead: Neighbour | None
    behind: Neighbour | None
    leg_is_driven: bool
    """Whether the robot ahead has driven the leg between the two."""
    back_by_m: Length = 0.0
    """How far the tail wants to come back along the path before the other end leads again; or 0."""
    counters: Counters = Counters()
    heals: bool = False
    """Whether it follows a formation with other members."""
    led_by: Annotated[int, Meta(ge=0, le=ROBOTS_MAX)] = 0
    """The leader of the last formation; 0: there was none."""
    stranded: Annotated[tuple[RobotId, ...], Meta(max_length=STRANDED_MAX)] = ()
    """Robots that found no way to a place in it. All members are told, since another one may lead later."""
    map_number: Count = 0
    seen: Seen | None = None
    """The newest map, for the leader."""
    first: Count
    """Index of the first vertex in this piece."""
    vertices: Count
    """How many vertices the whole path has."""
    path: Annotated[tuple[Vertex, ...], Meta(max_length=PIECE_VERTICES_MAX)]


class Plea(Struct, frozen=True, gc=False, kw_only=True, tag="plea"):
    """A robot that is left out asks the leader to be let in."""

    epoch: Epoch
    life: Life


ViewMessage = Report | Answer | Formation | Plea
"""All that is put on `view/{from}/{to}`."""
