"""Entries about views and strands: the fence, forming, turning round, dissolving, authority, links."""

from typing import Annotated

from msgspec import Meta

from protocol.fence import Cause, May
from protocol.frames import (
    ROBOTS_MAX,
    VERTICES_MAX,
    Count,
    Length,
    Metres,
    Point,
    RobotCount,
    RobotId,
    Seconds,
)
from protocol.timeline.base import Kind, LifeText, Robot, Text


class FenceChanged(Kind, frozen=True, kw_only=True, tag="fence.changed"):
    """The world has changed the fence of all bodies: they stand, and obey no older order any more."""

    epoch: Count
    turn: Count
    may: Annotated[May, Meta(description="who may move: `nobody`, `one`, `all`, or `stopped`")]
    coordinator: Annotated[Robot, Meta(description="0: the operator, or a world that was started again")]
    life: Annotated[LifeText, Meta(description="of the coordinator; hexadecimal")]
    named: Annotated[Robot, Meta(description="`one`: who may move; `all`: who leads; else 0")] = 0
    named_life: LifeText = ""
    members: Annotated[RobotCount, Meta(description="`all`: how many robots are in the strand")] = 0
    cause: Annotated[Cause | None, Meta(description="why the epoch was proposed; null: it is a turn")] = None


class ViewProposed(Kind, frozen=True, kw_only=True, tag="view.proposed"):
    """A robot proposes a view: all robots are to form a strand anew."""

    epoch: Count
    cause: Cause
    about: Annotated[RobotId | None, Meta(description="the robot that is the reason, if one is")] = None
    why: Text


class ViewJoined(Kind, frozen=True, kw_only=True, tag="view.joined"):
    """A robot has left its strand or earlier view: it stands, and reports to the coordinator of this one."""

    epoch: Count


class ViewLeft(Kind, frozen=True, kw_only=True, tag="view.left"):
    """A robot is left out of the strand of a view: it stands aside."""

    epoch: Count


class StrandFormed(Kind, frozen=True, kw_only=True, tag="strand.formed"):
    """The coordinator of a view has made its formation."""

    epoch: Count
    turn: Annotated[Count, Meta(description="from this turn of the fence on the strand may drive")]
    order: Annotated[
        tuple[RobotId, ...], Meta(min_length=1, max_length=ROBOTS_MAX, description="leader first")
    ]
    lives: Annotated[tuple[LifeText, ...], Meta(max_length=ROBOTS_MAX, description="of the robots, in order")]
    places_m: Annotated[
        tuple[Length, ...], Meta(max_length=ROBOTS_MAX, description="where each stands along the path")
    ]
    laid: Annotated[
        tuple[Point, ...], Meta(max_length=VERTICES_MAX, description="the path's corners, tail first")
    ]
    driven: Annotated[
        tuple[bool, ...], Meta(max_length=ROBOTS_MAX, description="whether each one's leg has been driven")
    ]
    back_by_m: Annotated[Length, Meta(description="how far the tail wants to return before it follows again")]
    sensed: Annotated[bool, Meta(description="whether robots took scans to find the order")]


class StrandJoined(Kind, frozen=True, kw_only=True, tag="strand.joined"):
    """A robot has its place in the strand."""

    epoch: Count
    rank: Annotated[RobotCount, Meta(description="the leader's is 0")]
    members: Annotated[RobotCount, Meta(description="how many robots are in the strand")] = 0


class StrandReversed(Kind, frozen=True, kw_only=True, tag="strand.reversed"):
    """The leader has the strand turn round: in the next view's strand the other end is first.

    Arc lengths refer to the epoch that ends.
    """

    epoch: Annotated[Count, Meta(description="the epoch that ends")]
    cut_m: Annotated[Length, Meta(description="where the new path ends")]
    end_m: Annotated[Length, Meta(description="where the new path begins: at the old leader")]
    back_by_m: Annotated[
        Length,
        Meta(description="how far the new tail wants to return; 0: the new leader plans on its own"),
    ]


class StrandDissolved(Kind, frozen=True, kw_only=True, tag="strand.dissolved"):
    """A robot whose way stays blocked has the strand dissolve: in the next view no places are kept."""

    epoch: Annotated[Count, Meta(description="the epoch that ends")]
    blocked: Annotated[RobotId, Meta(description="the robot whose way is blocked")]


class RobotStranded(Kind, frozen=True, kw_only=True, tag="robot.stranded"):
    """The coordinator finds no way to a place in the strand for a robot: the others go on without it."""

    epoch: Count
    robot: RobotId
    reason: Text
    by: Annotated[RobotId | None, Meta(description="whose body is in the way, as far as is known")] = None


class RobotPlaced(Kind, frozen=True, kw_only=True, tag="robot.placed"):
    """A robot that was not in place at the start has joined: it stands at the end of the strand."""

    rank: Annotated[RobotCount, Meta(description="its place in the strand; the leader's is 0")]
    turn: Annotated[Count, Meta(description="the turn in which it joined")]
    x_m: Metres
    y_m: Metres


class RobotBlocked(Kind, frozen=True, kw_only=True, tag="robot.blocked"):
    """A robot found no way to its place in its turn: it stands, and other robots get their turns first."""

    turn: Count
    reason: Text
    x_m: Metres
    y_m: Metres


class AuthorityGranted(Kind, frozen=True, kw_only=True, tag="authority.granted"):
    """A robot grants the robot behind it the path up to this arc length."""

    to: RobotId
    epoch: Count
    authority_m: Length


class LinkSilent(Kind, frozen=True, kw_only=True, tag="link.silent"):
    """A neighbour has been silent for `silence_s`; what it has granted may still be driven."""

    neighbour: RobotId
    silent_s: Seconds


class LinkHeard(Kind, frozen=True, kw_only=True, tag="link.heard"):
    """A silent neighbour is heard again."""

    neighbour: RobotId


class LinkBroken(Kind, frozen=True, kw_only=True, tag="link.broken"):
    """A robot has broken a link and left the strand; docs/strand.md, *View change*."""

    neighbour: RobotId
    cause: Annotated[
        str,
        Meta(description="`token`: its token is gone; `silence`: it is silent with a token"),
    ]
    silent_s: Seconds


class LeaderSucceeded(Kind, frozen=True, kw_only=True, tag="leader.succeeded"):
    """A robot has become the leader of the strand."""

    epoch: Count
    before: Annotated[RobotId | None, Meta(description="the former leader, as far as it knows")]


class StrandHealed(Kind, frozen=True, kw_only=True, tag="strand.healed"):
    """The strand drives again after a formation with other members; its leader says so."""

    epoch: Count
    robots: Annotated[RobotCount, Meta(description="how many robots are in the strand")]


class RobotHeld(Kind, frozen=True, kw_only=True, tag="robot.held"):
    """A robot waits for the robot behind it, though it could drive on: the stretch rule."""

    behind_m: Annotated[Length, Meta(description="how far the robot behind is from the end of its authority")]


class RobotReleased(Kind, frozen=True, kw_only=True, tag="robot.released"):
    """The wait for the robot behind is over."""
