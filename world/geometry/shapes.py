"""The shapes of obstacles, and arrays of all of them [m, rad; world frame]."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct

from protocol.arrays import Floats, Indices
from protocol.frames import Metres, Radians
from world.geometry import rings

ROUNDED_RAD = math.pi / 3
"""Several blunt corners together may be as sharp as this: the tip of a pointed arch between its feet."""

Position = Annotated[tuple[Metres, Metres], Meta(description="x, y [m; world frame]")]
Extent = Annotated[float, Meta(gt=0.0, le=1e4, description="m")]


class _Shape(Struct, frozen=True, kw_only=True, tag_field="shape", forbid_unknown_fields=True):
    """The base of all shapes: the field for the kind of shape."""


class Circle(_Shape, frozen=True, kw_only=True, tag="circle"):
    """A disc."""

    centre_m: Position
    radius_m: Annotated[Extent, Meta(description="m, from its centre to its outline")]

    @property
    def smallest_width_m(self) -> float:
        """Its least width."""
        return 2.0 * self.radius_m

    @property
    def sharpest_corner_rad(self) -> float:
        """The angle of the sharpest wedge that fits over its outline; see `Ellipse`."""
        return math.pi / 2


class Ellipse(_Shape, frozen=True, kw_only=True, tag="ellipse"):
    """A filled ellipse; its first semi-axis is rotated by `rotation_rad` anti-clockwise from the x axis."""

    centre_m: Position
    semi_axes_m: Annotated[
        tuple[Extent, Extent], Meta(description="m, from its centre to its outline, along each of its axes")
    ]
    rotation_rad: Annotated[
        Radians, Meta(description="rad, from the world's x axis to its first axis, anti-clockwise")
    ] = 0.0

    @property
    def smallest_width_m(self) -> float:
        """Its least width."""
        return 2.0 * min(self.semi_axes_m)

    @property
    def sharpest_corner_rad(self) -> float:
        """The angle of the sharpest wedge that fits over its outline.

        Of all caps that a chord can cut off, half the ellipse is the tallest relative to its chord. It is as
        tall as the wedge of the rhombus through the four ends of the axes.
        """
        return 2.0 * math.atan(min(self.semi_axes_m) / max(self.semi_axes_m))


class Polygon(_Shape, frozen=True, kw_only=True, tag="polygon"):
    """A simple polygon, convex or not; vertices in either orientation, the first is not repeated."""

    vertices_m: Annotated[
        tuple[Position, ...],
        Meta(min_length=3, max_length=2000, description="its corners, in order: x, y [m; world frame]"),
    ]

    def __post_init__(self) -> None:
        if not rings.is_simple(self.ring_m):
            x_m, y_m = self.vertices_m[0]
            got = f"one from ({x_m:.6g}, {y_m:.6g}) that meets itself"
            raise ValueError(f"vertices_m must make a simple ring, no corner twice, got {got}")

    @property
    def ring_m(self) -> Floats:
        """The vertices, `(n, 2)`."""
        return np.array(self.vertices_m, dtype=np.float64)

    @property
    def smallest_width_m(self) -> float:
        """Its least width."""
        return rings.smallest_width_m(self.ring_m)

    @property
    def bluntest_rad(self) -> float:
        """The angle that it counts for if all its corners are blunter; see `agents/navigation/sure.py`."""
        return math.pi / 2 if len(self.vertices_m) <= 4 else ROUNDED_RAD

    @property
    def sharpest_corner_rad(self) -> float:
        """The least interior angle, or what several corners together may be."""
        return min(float(rings.corners_rad(self.ring_m).min()), self.bluntest_rad)


Shape = Circle | Ellipse | Polygon


@dataclass(frozen=True)
class Ground:
    """All obstacles, packed by kind; the `*_owner` arrays map each row to its shape in the scenario."""

    shape_count: int
    circles: Floats
    """`(k, 3)`: x, y, radius."""
    circle_owner: Indices
    ellipses: Floats
    """`(k, 5)`: x, y, first and second semi-axis, rotation."""
    ellipse_owner: Indices
    edges: Floats
    """`(k, 4)`: from x, y to x, y; the edges of one polygon are consecutive, anti-clockwise."""
    edge_owner: Indices

    @cached_property
    def ellipse_reach_m(self) -> tuple[Floats, Floats]:
        """`(k,)`: the largest and the least distance of each outline from its centre."""
        axes_m = self.ellipses[:, 2:4]
        return axes_m.max(axis=1, initial=0.0), axes_m.min(axis=1, initial=math.inf)

    @cached_property
    def edge_middles(self) -> tuple[Floats, Floats]:
        """`(k, 2)`: the midpoints of the edges; and `(k,)`: half of their lengths."""
        starts, ends = self.edges[:, :2], self.edges[:, 2:]
        return (starts + ends) / 2.0, np.hypot(*(ends - starts).T) / 2.0

    @cached_property
    def inner_radii_m(self) -> Floats:
        """`(k,)`: of a disc within each of what `discs` are around; an edge is as near as its midpoint."""
        of_edges = np.zeros(len(self.edges))
        return np.concatenate((self.circles[:, 2], self.ellipse_reach_m[1], of_edges))

    @cached_property
    def discs(self) -> Floats:
        """`(k, 3)`: x, y, radius of a disc around each circle, then each ellipse, then each edge."""
        middles, half_lengths_m = self.edge_middles
        of_ellipses = np.column_stack((self.ellipses[:, :2], self.ellipse_reach_m[0]))
        return np.vstack((self.circles, of_ellipses, np.column_stack((middles, half_lengths_m))))

    @cached_property
    def _boxes_m(self) -> tuple[Floats, Floats]:
        """`(shape_count, 2)`: the lower left and the upper right corner of a box around each shape."""
        owners = np.concatenate((self.circle_owner, self.ellipse_owner, self.edge_owner))
        low, high = np.full((self.shape_count, 2), math.inf), np.full((self.shape_count, 2), -math.inf)
        np.minimum.at(low, owners, self.discs[:, :2] - self.discs[:, 2:])
        np.maximum.at(high, owners, self.discs[:, :2] + self.discs[:, 2:])
        return low, high

    def within(self, low: Floats, high: Floats) -> "Ground":
        """The same ground without some of the shapes that do not reach into this box; owners stay."""
        boxes_low, boxes_high = self._boxes_m
        is_in = np.asarray(((boxes_low <= high) & (boxes_high >= low)).all(axis=1))
        circles, ellipses = is_in[self.circle_owner], is_in[self.ellipse_owner]
        edges = is_in[self.edge_owner]
        return Ground(
            shape_count=self.shape_count,
            circles=self.circles[circles],
            circle_owner=self.circle_owner[circles],
            ellipses=self.ellipses[ellipses],
            ellipse_owner=self.ellipse_owner[ellipses],
            edges=self.edges[edges],
            edge_owner=self.edge_owner[edges],
        )


def ground_of(shapes: Sequence[Shape]) -> Ground:
    """Pack shapes into arrays."""
    circles: list[tuple[float, ...]] = []
    ellipses: list[tuple[float, ...]] = []
    edges: list[Floats] = []
    owners: tuple[list[int], list[int], list[int]] = ([], [], [])
    for index, shape in enumerate(shapes):
        match shape:
            case Circle():
                circles.append((*shape.centre_m, shape.radius_m))
                owners[0].append(index)
            case Ellipse():
                ellipses.append((*shape.centre_m, *shape.semi_axes_m, shape.rotation_rad))
                owners[1].append(index)
            case Polygon():
                ring = rings.anticlockwise(shape.ring_m)
                edges.append(np.hstack((ring, np.roll(ring, -1, axis=0))))
                owners[2].extend([index] * len(ring))
    packed = [np.array(owner, dtype=np.intp) for owner in owners]
    return Ground(
        shape_count=len(shapes),
        circles=np.array(circles, dtype=np.float64).reshape(-1, 3),
        circle_owner=packed[0],
        ellipses=np.array(ellipses, dtype=np.float64).reshape(-1, 5),
        ellipse_owner=packed[1],
        edges=np.vstack(edges) if edges else np.empty((0, 4)),
        edge_owner=packed[2],
    )
