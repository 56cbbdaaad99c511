"""What robots record of the strand: how it forms, turns round, dissolves and heals; grants and links."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import ROBOTS_MAX, Count, Length, Metres, Point, RobotId, Seconds
from protocol.timeline.base import Kind, Text


class StrandFormed(Kind, frozen=True, kw_only=True, tag="strand.formed"):
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


class StrandReversed(Kind, frozen=True, kw_only=True, tag="strand.reversed"):
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


class StrandDissolved(Kind, frozen=True, kw_only=True, tag="strand.dissolved"):
    """The robot that leads has the strand dissolve: a robot's way is blocked, and stays so.

    In the next epoch all line up again, from where they stand; the strand that then forms has the one after.
    """

    epoch: Annotated[Count, Meta(description="that ends")]
    blocked: Annotated[RobotId, Meta(description="the robot whose way is blocked")]


class RobotPlaced(Kind, frozen=True, kw_only=True, tag="robot.placed"):
    """A robot that was not in place at the start has joined: it stands at the strand's end."""

    rank: Annotated[Count, Meta(description="its place in the strand; the leader's is 0")]
    turn: Annotated[Count, Meta(description="in which it joined, alone")]
    x_m: Metres
    y_m: Metres


class RobotBlocked(Kind, frozen=True, kw_only=True, tag="robot.blocked"):
    """A robot that had its turn to join found no way: it stands, and others have theirs first."""

    turn: Count
    reason: Text
    x_m: Metres
    y_m: Metres


class AuthorityGranted(Kind, frozen=True, kw_only=True, tag="authority.granted"):
    """A robot lets the one behind it drive up to this arc length of its path."""

    to: RobotId
    epoch: Count
    authority_m: Length


class LinkSilent(Kind, frozen=True, kw_only=True, tag="link.silent"):
    """A neighbour has not been heard for `silence_s`: the robot stands until it is."""

    neighbour: RobotId
    silent_s: Seconds


class LinkHeard(Kind, frozen=True, kw_only=True, tag="link.heard"):
    """A silent neighbour has been heard again."""

    neighbour: RobotId


class LinkBroken(Kind, frozen=True, kw_only=True, tag="link.broken"):
    """A robot has given a link up, and has left the strand: docs/strand.md, Healing."""

    neighbour: RobotId
    cause: Annotated[str, Meta(description="`token`: it shows none any more; `silence`: it does")]
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
    """A robot leads now that did not lead the strand before."""

    epoch: Count
    before: Annotated[RobotId | None, Meta(description="who led as far as it knows")]


class StrandHealed(Kind, frozen=True, kw_only=True, tag="strand.healed"):
    """The leader of a strand that was called has heard the robot behind it, and may go on."""

    epoch: Count
    members: Annotated[tuple[RobotId, ...], Meta(max_length=ROBOTS_MAX)]


class RobotHeld(Kind, frozen=True, kw_only=True, tag="robot.held"):
    """A robot that might drive on waits for the one behind it: the stretch rule."""

    behind_m: Annotated[Length, Meta(description="how far it is behind what it has been granted")]


class RobotReleased(Kind, frozen=True, kw_only=True, tag="robot.released"):
    """The wait is over."""
