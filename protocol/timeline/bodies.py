"""Entries of the world about bodies: the orders they accept, their poses, their scans."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import Count, Length, Metres, Point, Radians, RobotId
from protocol.timeline.base import Kind, LifeText, Text

RANGES_TOLD_MAX = 360  # rays of a recorded scan: enough for a drawing, in 2 kB


class OrderAccepted(Kind, frozen=True, kw_only=True, tag="order.accepted"):
    """A body has accepted a new drive order."""

    robot: RobotId
    number: Count
    epoch: Annotated[Count, Meta(description="of the fence that the order bears")]
    turn: Annotated[Count, Meta(description="of that fence")]
    life: Annotated[LifeText, Meta(description="of the robot; hexadecimal")]
    step: Annotated[Count, Meta(description="the leader's switching step; 0: a robot that follows or joins")]
    x_m: Metres
    y_m: Metres
    target: Annotated[Point | None, Meta(description="null: stand still")]
    reach_m: Annotated[Length, Meta(description="arc length of the target along the strand's path")]


class OrderRefused(Kind, frozen=True, kw_only=True, tag="order.refused"):
    """A body has refused an order: it is void, or the drive cannot execute it."""

    robot: RobotId
    number: Count
    epoch: Annotated[Count, Meta(description="of the fence that the order bears")]
    turn: Count
    fence: Annotated[Count, Meta(description="the epoch of the fence that the body obeys")]
    fence_turn: Count
    reason: Text


class OrderFinished(Kind, frozen=True, kw_only=True, tag="order.finished"):
    """A body has finished an order."""

    robot: RobotId
    number: Count
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(description="least clearance during the order, or the whole step; null: no obstacle"),
    ]


class StepFinished(Kind, frozen=True, kw_only=True, tag="step.finished"):
    """The leader's body has reached the end of a switching step."""

    robot: RobotId
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(description="least clearance in the whole step, to compare with the promise; null: no obstacle"),
    ]


class BodyStopped(Kind, frozen=True, kw_only=True, tag="body.stopped"):
    """The dead-man stop: the body stops because its robot has been silent too long."""

    robot: RobotId


class PoseSampled(Kind, frozen=True, kw_only=True, tag="pose.sampled"):
    """A body's true pose; between two samples the body moved straight."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians
    clearance_m: Annotated[
        Metres | None,
        Meta(
            description="of its hull here, to the nearest obstacle that never moves, to the micrometre; "
            "null: there is none, or the log is older than this field"
        ),
    ] = None
    separation_m: Annotated[
        Metres | None,
        Meta(description="likewise, to the nearest other hull; null: the robot is alone, or as above"),
    ] = None


class ScanServed(Kind, frozen=True, kw_only=True, tag="scan.served"):
    """A body's sensor was read at its robot's request."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians
    revolutions: Annotated[Count, Meta(description="of the scanner; their rays interlace")]
    hits: Count
    ranges_m: Annotated[
        tuple[Length, ...],
        Meta(
            max_length=RANGES_TOLD_MAX,
            description="at most 360 rays, evenly spaced, to the millimetre, from -pi; "
            "the range limit: no hit; empty: not recorded",
        ),
    ] = ()
