"""Entries of robots about the strand: forming, reversing, dissolving, healing, authority, links."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import ROBOTS_MAX, Count, Length, Metres, Point, RobotId, Seconds
from protocol.timeline.base import Kind, Text


class StrandFormed(Kind, frozen=True, kw_only=True, tag="strand.formed"):
    """The robot has its place in a strand that forms."""

    epoch: Count
    sensed: Annotated[bool, Meta(description="whether the robot took a scan to find the order of the strand")]
    order: Annotated[tuple[RobotId, ...], Meta(min_length=1, description="leader first")]
    path_length_m: Annotated[Length, Meta(description="arc length of the leader's start; the tail's is 0")]
    laid: Annotated[
        tuple[Point, ...],
        Meta(
            max_length=2000,
            description="from the leader, where the path bends between robots: its corners, tail first",
        ),
    ] = ()


class StrandReversed(Kind, frozen=True, kw_only=True, tag="strand.reversed"):
    """The leader reverses the strand: from the next epoch on the other end leads.

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
    """The leader dissolves the strand, because a robot's way stays blocked.

    In the next epoch all robots line up again from their positions; the new strand has the epoch after that.
    """

    epoch: Annotated[Count, Meta(description="the epoch that ends")]
    blocked: Annotated[RobotId, Meta(description="the robot whose way is blocked")]


class RobotPlaced(Kind, frozen=True, kw_only=True, tag="robot.placed"):
    """A robot that was not in place at the start has joined: it stands at the end of the strand."""

    rank: Annotated[Count, Meta(description="its place in the strand; the leader's is 0")]
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
    """A neighbour has been silent for `silence_s`: the robot stands until it is heard again."""

    neighbour: RobotId
    silent_s: Seconds


class LinkHeard(Kind, frozen=True, kw_only=True, tag="link.heard"):
    """A silent neighbour is heard again."""

    neighbour: RobotId


class LinkBroken(Kind, frozen=True, kw_only=True, tag="link.broken"):
    """A robot has broken a link and left the strand: docs/strand.md, Healing."""

    neighbour: RobotId
    cause: Annotated[
        str,
        Meta(description="`token`: its token is gone; `silence`: it is silent with a token"),
    ]
    silent_s: Seconds


class MusterCalled(Kind, frozen=True, kw_only=True, tag="muster.called"):
    """A robot has called all members to line up again."""

    epoch: Count
    members: Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]
    why: Text


class MusterJoined(Kind, frozen=True, kw_only=True, tag="muster.joined"):
    """A robot has left whatever it was in for a muster that was called."""

    epoch: Count


class LeaderSucceeded(Kind, frozen=True, kw_only=True, tag="leader.succeeded"):
    """A robot has become the leader of the strand."""

    epoch: Count
    before: Annotated[RobotId | None, Meta(description="the former leader, as far as it knows")]


class StrandHealed(Kind, frozen=True, kw_only=True, tag="strand.healed"):
    """The leader of a re-formed strand has heard the robot behind it and can drive on."""

    epoch: Count
    members: Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class RobotHeld(Kind, frozen=True, kw_only=True, tag="robot.held"):
    """A robot waits for the robot behind it, though it could drive on: the stretch rule."""

    behind_m: Annotated[Length, Meta(description="how far the robot behind is from the end of its authority")]


class RobotReleased(Kind, frozen=True, kw_only=True, tag="robot.released"):
    """The wait for the robot behind is over."""
