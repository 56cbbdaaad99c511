"""Moving obstacles: shapes on tracks through time.

Rule 1: an obstacle goes straight and evenly from one place of its track to the next, and does not turn.
Rule 2: it stands at the first place until its track begins, and at the last once it has ended.
Rule 3: one that stands is a moving obstacle all the same.
"""

import math
from itertools import pairwise
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import Metres, Seconds
from world.geometry.shapes import Circle, Extent, Polygon

Name = Annotated[str, Meta(min_length=1, max_length=100)]
Track = Annotated[
    tuple[tuple[Seconds, Metres, Metres], ...],
    Meta(min_length=1, max_length=10_000, description="when it is where: t [s], x, y [m; world frame]"),
]
Corner = Annotated[
    tuple[Metres, Metres], Meta(description="x, y [m], from the place on the track; the world frame's axes")
]


class _Moving(Struct, frozen=True, kw_only=True, tag_field="shape", forbid_unknown_fields=True):
    """What all moving obstacles share: a name, a track, and the field that says which shape it is."""

    id: Annotated[Name, Meta(description="what the timeline and refusals call it")]
    track: Track

    @property
    def speed_mps_max(self) -> float:
        """How fast it is on its fastest leg; times have to increase."""
        legs = pairwise(self.track)
        return max((math.dist(one[1:], other[1:]) / (other[0] - one[0]) for one, other in legs), default=0.0)


class MovingCircle(_Moving, frozen=True, kw_only=True, tag="circle"):
    """A disc; its track is its centre's."""

    radius_m: Annotated[Extent, Meta(description="m, from its centre to its outline")]

    @property
    def outline(self) -> Circle:
        """The shape, as it lies round its place on the track."""
        return Circle(centre_m=(0.0, 0.0), radius_m=self.radius_m)

    @property
    def reach_m(self) -> float:
        """How far it reaches from its place on the track."""
        return self.radius_m


class MovingPolygon(_Moving, frozen=True, kw_only=True, tag="polygon"):
    """A simple polygon, convex or not, which its track carries along without turning it."""

    vertices_m: Annotated[
        tuple[Corner, ...],
        Meta(min_length=3, max_length=2000, description="its corners, in order: x, y [m; from its place]"),
    ]

    def __post_init__(self) -> None:
        Polygon(vertices_m=self.vertices_m)  # which refuses a ring that is not simple

    @property
    def outline(self) -> Polygon:
        """The shape, as it lies round its place on the track."""
        return Polygon(vertices_m=self.vertices_m)

    @property
    def reach_m(self) -> float:
        """How far it reaches from its place on the track."""
        return max(math.hypot(*vertex) for vertex in self.vertices_m)


Moving = MovingCircle | MovingPolygon
