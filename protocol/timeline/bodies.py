"""What the world records of bodies: the orders that they take, where they are, what they sense."""

from typing import Annotated

from msgspec import Meta

from protocol.frames import Count, Length, Metres, Point, Radians, RobotId
from protocol.timeline.base import Kind, Text

RANGES_TOLD_MAX = 360  # of a scan: enough to draw it, in 2 kB


class OrderAccepted(Kind, frozen=True, kw_only=True, tag="order.accepted"):
    """A body has taken a new drive order."""

    robot: RobotId
    number: Count
    epoch: Count
    step: Annotated[
        Count, Meta(description="the leader's switching step; 0 for one that follows, or joins in epoch 0")
    ]
    x_m: Metres
    y_m: Metres
    target: Annotated[Point | None, Meta(description="null: stand still")]
    reach_m: Annotated[Length, Meta(description="arc length of the target along the strand's path")]


class OrderRefused(Kind, frozen=True, kw_only=True, tag="order.refused"):
    """A body has not taken an order: it is void, or the drive cannot do it."""

    robot: RobotId
    number: Count
    reason: Text


class OrderFinished(Kind, frozen=True, kw_only=True, tag="order.finished"):
    """A body has driven an order to its end."""

    robot: RobotId
    number: Count
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(description="least clearance while driving it, or the whole step; null: no obstacle"),
    ]


class StepFinished(Kind, frozen=True, kw_only=True, tag="step.finished"):
    """The leader's body stands at the end of a switching step."""

    robot: RobotId
    step: Count
    x_m: Metres
    y_m: Metres
    clearance_m: Annotated[
        Metres | None,
        Meta(
            description="least clearance in the whole step, to hold against the promised; null: no obstacle"
        ),
    ]


class BodyStopped(Kind, frozen=True, kw_only=True, tag="body.stopped"):
    """The dead-man stop: its robot has been silent too long."""

    robot: RobotId


class PoseSampled(Kind, frozen=True, kw_only=True, tag="pose.sampled"):
    """A body's true pose; between two samples of a body it moved straight."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians


class ScanServed(Kind, frozen=True, kw_only=True, tag="scan.served"):
    """A body's sensor has been read, because its robot asked."""

    robot: RobotId
    x_m: Metres
    y_m: Metres
    heading_rad: Radians
    revolutions: Annotated[Count, Meta(description="of the scanner, interlaced: rays beside rays")]
    hits: Count
    ranges_m: Annotated[
        tuple[Length, ...],
        Meta(
            max_length=RANGES_TOLD_MAX,
            description="of at most 360 rays, evenly spread, to the millimetre; the first looks along -pi; "
            "the range limit: no hit; empty: not told",
        ),
    ] = ()
