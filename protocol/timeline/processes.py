"""Processes that come and go: robots, routers, the world itself."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import Count, RobotId, Seconds
from protocol.timeline.base import Kind, Text


class RobotAppeared(Kind, frozen=True, kw_only=True, tag="robot.appeared"):
    """The world has seen a robot's liveliness token."""

    robot: RobotId


class RobotDied(Kind, frozen=True, kw_only=True, tag="robot.died"):
    """A robot's token has gone, and it has said nothing for the grace time, before the run was over."""

    robot: RobotId
    silent_since_s: Annotated[Seconds, Meta(description="basis of the last order that was heard from it")]


class RobotRestarted(Kind, frozen=True, kw_only=True, tag="robot.restarted"):
    """A robot's token has come that bears another incarnation: a new process has taken its place."""

    robot: RobotId


class RobotReturned(Kind, frozen=True, kw_only=True, tag="robot.returned"):
    """A robot that was taken for dead is there again, in the same process: it was frozen, or cut off."""

    robot: RobotId


class RouterLost(Kind, frozen=True, kw_only=True, tag="router.lost"):
    """The router that carried the world is no more there: nobody can be heard."""


class RouterFound(Kind, frozen=True, kw_only=True, tag="router.found"):
    """A router carries the world again, the same one or another."""

    away_s: Annotated[Seconds, Meta(description="wall clock: for how long there was none")]


class WorldResumed(Kind, frozen=True, kw_only=True, tag="world.resumed"):
    """A world whose process was killed goes on from its own timeline: bodies stand where that saw them last.

    What chance does to drives and scans comes from new streams, which bear the number of the life.
    """

    life: Annotated[Count, Meta(description="1: the first time")]
    entries: Annotated[Count, Meta(description="that it found, of all sources")]
    torn_bytes: Annotated[Count, Meta(description="of a last line that was not whole; it is cut off")]


class RobotStarted(Kind, frozen=True, kw_only=True, tag="robot.started"):
    """A robot's process has its mission and begins."""

    pid: Count
    incarnation: Annotated[Text, Meta(description="as in its liveliness token")] = ""


class RobotFailed(Kind, frozen=True, kw_only=True, tag="robot.failed"):
    """A robot's core has raised an exception, which it never should: the process ends."""

    reason: Text
