"""Numbers with bounds, points and poses, for messages and the timeline.

Every float has bounds. They also refuse NaN and infinity, since NaN compares false with both bounds.
"""

import math
from typing import Annotated

from msgspec import Meta, Struct

METRES_MAX = 1e6
Metres = Annotated[float, Meta(ge=-METRES_MAX, le=METRES_MAX)]
Length = Annotated[float, Meta(ge=0.0, le=METRES_MAX, description="m")]
Seconds = Annotated[float, Meta(ge=0.0, le=1e9)]
SPEED_MPS_MAX = 100.0
Speed = Annotated[float, Meta(ge=0.0, le=SPEED_MPS_MAX)]
Radians = Annotated[float, Meta(ge=-math.pi, le=math.pi)]
COUNT_MAX = 2**53  # JSON readers keep integers exact up to here
Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]
ROBOTS_MAX = 2000  # what a robot has sent to so many fits into one `robot.settled` of 33 kB
VERTICES_MAX = 4000  # of a formation's path: not so many fit into its record
FLEETS_MAX = 250  # on one ground: 1,000 robots as strands of four
RobotId = Annotated[int, Meta(ge=1, le=ROBOTS_MAX)]
RobotCount = Annotated[int, Meta(ge=0, le=ROBOTS_MAX)]  # also a rank: its reader may list so many robots


class Point(Struct, frozen=True, gc=False, kw_only=True):
    """A place [m; world frame]."""

    x_m: Metres
    y_m: Metres


class Pose(Struct, frozen=True, gc=False, kw_only=True):
    """A body's position and heading [m, rad in (-pi, pi]; world frame]."""

    x_m: Metres
    y_m: Metres
    heading_rad: Radians


class Vertex(Struct, frozen=True, gc=False, kw_only=True):
    """A corner of a path and its arc length along that path [m; world frame]."""

    x_m: Metres
    y_m: Metres
    s_m: Length


def apart_m(one: Point | Pose | Vertex, other: Point | Pose | Vertex) -> float:
    """The distance between two places."""
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)


def one_more(count: int) -> int:
    """The next count. After the last that a message has room for, which a peer may have told, that again."""
    return min(count + 1, COUNT_MAX)


def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, math.tau)
    return math.pi if wrapped == -math.pi else wrapped
