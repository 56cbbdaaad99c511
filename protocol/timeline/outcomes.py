"""Entries about the outcome of a run: arrivals, a lost route, broken promises, the end."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import Length, Metres, RobotId, Seconds
from protocol.timeline.base import Kind, Text


class GoalReached(Kind, frozen=True, kw_only=True, tag="goal.reached"):
    """The leader stands within the goal's tolerance or, without a goal, at its last switching position."""

    x_m: Metres
    y_m: Metres


class RobotArrived(Kind, frozen=True, kw_only=True, tag="robot.arrived"):
    """A robot has arrived: it leads, or it stands in place behind a robot that has arrived."""

    progress_m: Length


class RouteLost(Kind, frozen=True, kw_only=True, tag="route.lost"):
    """The leader has lost its route: it stops, and the run ends."""

    reason: Text


class LawFailed(Kind, frozen=True, kw_only=True, tag="law.failed"):
    """The leader has asked a law of a user, which has raised an exception or returned what is no step.

    Where obstacles move, it is asked again later.
    """

    reason: Text


class LawStalled(Kind, frozen=True, kw_only=True, tag="law.stalled"):
    """A law of a user has not returned for a long time; until it does, its robot does nothing else.

    It is recorded once for each call, and only in live fleets.
    """

    law: Text
    after_s: Annotated[Seconds, Meta(description="wall clock: it has not returned for at least so long")]
    at: Annotated[Text, Meta(description="where it was then, such as `mylaw.py:12`")]


class PromiseBroken(Kind, frozen=True, kw_only=True, tag="promise.broken"):
    """An invariant was violated, by true poses or by recorded entries; docs/verdict.md lists them."""

    invariant: Annotated[str, Meta(pattern="^(S[1-4]|F[1-6]|P[1-7]|A[12])$")]
    robot: RobotId
    other: Annotated[RobotId | None, Meta(description="the other robot, where two are involved")] = None
    measured_m: Annotated[Metres | None, Meta(description="null: the invariant has no length")] = None
    required_m: Metres | None = None
    why: Text


class RunEnded(Kind, frozen=True, kw_only=True, tag="run.ended"):
    """The world has ended the run."""

    reason: Text
