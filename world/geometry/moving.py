"""Moving obstacles: shapes on tracks through time.

Rule 1: an obstacle moves straight at constant speed from one place of its track to the next, without turning.
Rule 2: it stands at the first place until its track begins, and at the last place after its track has ended.
Rule 3: a moving obstacle that stands still counts as a moving obstacle.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import Metres, Seconds
from world.geometry.shapes import Circle, Extent, Polygon

Name = Annotated[str, Meta(min_length=1, max_length=100)]
Track = Annotated[
    tuple[tuple[Seconds, Metres, Metres], ...],
    Meta(min_length=1, max_length=10_000, description="its places over time: t [s], x, y [m; world frame]"),
]
Corner = Annotated[
    tuple[Metres, Metres],
    Meta(description="x, y [m] relative to the place on the track; world axes"),
]


def speed_mps_max(track: Track) -> float:
    """The speed on the fastest leg of a track, but for legs that take no time, which no scenario may have."""
    legs = [(one, other) for one, other in pairwise(track) if other[0] > one[0]]
    return max((math.dist(one[1:], other[1:]) / (other[0] - one[0]) for one, other in legs), default=0.0)


class _Moving(Struct, frozen=True, kw_only=True, tag_field="shape", forbid_unknown_fields=True):
    """The base of all moving obstacles: a name, a track, and the field for the shape."""

    id: Annotated[Name, Meta(description="its name in the timeline and in error messages")]
    track: Track

    @property
    def speed_mps_max(self) -> float:
        """The speed on its fastest leg."""
        return speed_mps_max(self.track)


class MovingCircle(_Moving, frozen=True, kw_only=True, tag="circle"):
    """A disc; the track is that of its centre."""

    radius_m: Annotated[Extent, Meta(description="m, from its centre to its outline")]

    @property
    def outline(self) -> Circle:
        """The shape relative to its place on the track."""
        return Circle(centre_m=(0.0, 0.0), radius_m=self.radius_m)

    @property
    def reach_m(self) -> float:
        """The largest distance of its outline from its place on the track."""
        return self.radius_m


class MovingPolygon(_Moving, frozen=True, kw_only=True, tag="polygon"):
    """A simple polygon, convex or not, that moves along its track without turning."""

    vertices_m: Annotated[
        tuple[Corner, ...],
        Meta(min_length=3, max_length=2000, description="its corners, in order: x, y [m; from its place]"),
    ]

    def __post_init__(self) -> None:
        Polygon(vertices_m=self.vertices_m)  # refuses a ring that is not simple

    @property
    def outline(self) -> Polygon:
        """The shape relative to its place on the track."""
        return Polygon(vertices_m=self.vertices_m)

    @property
    def reach_m(self) -> float:
        """The largest distance of its outline from its place on the track."""
        return max(math.hypot(*vertex) for vertex in self.vertices_m)


Moving = MovingCircle | MovingPolygon


def top_speed_mps(moving: Sequence[Moving], said_mps: float | None) -> float:
    """The top speed of any of these: as a scenario says, or that of the fastest leg of any track."""
    return max((each.speed_mps_max for each in moving), default=0.0) if said_mps is None else said_mps
