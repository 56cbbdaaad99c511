"""Entries about processes that start and end: robots, routers, the world itself."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import Count, RobotId, Seconds
from protocol.timeline.base import Kind, Text


class RobotAppeared(Kind, frozen=True, kw_only=True, tag="robot.appeared"):
    """The world has seen a robot's liveliness token."""

    robot: RobotId
    incarnation: Annotated[Text, Meta(description="as in the token")] = ""


class RobotDied(Kind, frozen=True, kw_only=True, tag="robot.died"):
    """A robot's token vanished before the run was over, and the robot was silent for the grace time."""

    robot: RobotId
    silent_since_s: Annotated[Seconds, Meta(description="basis of the last order received from it")]


class RobotRestarted(Kind, frozen=True, kw_only=True, tag="robot.restarted"):
    """A robot's token has appeared with another incarnation: a new process has replaced the old one."""

    robot: RobotId
    incarnation: Annotated[Text, Meta(description="as in the token")] = ""


class RobotReturned(Kind, frozen=True, kw_only=True, tag="robot.returned"):
    """A robot that was declared dead is back, in the same process: it was frozen or cut off."""

    robot: RobotId


class RouterLost(Kind, frozen=True, kw_only=True, tag="router.lost"):
    """The world has lost its router: it cannot receive any message."""


class RouterFound(Kind, frozen=True, kw_only=True, tag="router.found"):
    """The world is connected to a router again, to the same one or another."""

    away_s: Annotated[Seconds, Meta(description="wall clock: time without a router")]


class WorldResumed(Kind, frozen=True, kw_only=True, tag="world.resumed"):
    """A world whose process was killed resumes from its timeline: bodies stand at their last recorded poses.

    The errors of drives and scans come from new random streams, which depend on the number of the life.
    """

    life: Annotated[Count, Meta(description="1: resumed for the first time")]
    entries: Annotated[Count, Meta(description="number of entries found, of all sources")]
    torn_bytes: Annotated[Count, Meta(description="length of an incomplete last line, which is removed")]


class RobotStarted(Kind, frozen=True, kw_only=True, tag="robot.started"):
    """A robot's process has received its mission and begins."""

    pid: Count
    incarnation: Annotated[Text, Meta(description="as in its liveliness token")] = ""


class RobotFailed(Kind, frozen=True, kw_only=True, tag="robot.failed"):
    """A robot's core raised an exception, which is a bug: the process ends."""

    reason: Text
