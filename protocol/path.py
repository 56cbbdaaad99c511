"""A path: the polyline that a robot drives, with arc length along it. It only ever grows at its end."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from protocol.arrays import Floats
from protocol.frames import Point, Vertex

ON_LINE_M = 1e-9  # nearer than this to a straight line counts as on it: rounding of sums of metres


def straightened(points: Sequence[Point]) -> list[Point]:
    """The corners of a polyline: places on the straight way between two others are left out."""
    corners: list[Point] = []
    for point, following in zip(points, [*points[1:], None], strict=True):
        if corners and following is not None and _is_on_way(corners[-1], point, following):
            continue
        corners.append(point)
    return corners


def _is_on_way(start: Point, point: Point, end: Point) -> bool:
    along_x, along_y = end.x_m - start.x_m, end.y_m - start.y_m
    off_x, off_y = point.x_m - start.x_m, point.y_m - start.y_m
    length_m = math.hypot(along_x, along_y)
    beside_m = abs(along_x * off_y - along_y * off_x)
    between = 0.0 <= along_x * off_x + along_y * off_y <= length_m**2
    # Where the end is the start again, all places are on its line, and none is on the way.
    return length_m > 0.0 and between and beside_m <= ON_LINE_M * length_m


class Path:
    """Vertices with arc length from the first one [m; world frame]."""

    def __init__(self, points: Iterable[Point]) -> None:
        self._vertices: list[Vertex] = []
        for point in points:
            self.extend(point)

    def __len__(self) -> int:
        return len(self._vertices)

    def __iter__(self) -> Iterator[Vertex]:
        return iter(self._vertices)

    def __getitem__(self, index: int) -> Vertex:
        return self._vertices[index]

    @property
    def end_m(self) -> float:
        """Arc length of the last vertex."""
        return self._vertices[-1].s_m

    def extend(self, point: Point) -> Vertex:
        """Add a vertex at the end; returns it with its arc length."""
        s_m = 0.0
        if self._vertices:
            last = self._vertices[-1]
            s_m = last.s_m + math.hypot(point.x_m - last.x_m, point.y_m - last.y_m)
        self._vertices.append(Vertex(x_m=point.x_m, y_m=point.y_m, s_m=s_m))
        return self._vertices[-1]

    def reversed(self, cut_m: float, end_m: float) -> "Path":
        """The part between two arc lengths the other way: its arc length 0 is at `end_m` of this one."""
        inner = [vertex for vertex in self._vertices if cut_m < vertex.s_m < end_m]
        corners: list[Point | Vertex] = [self.at(end_m), *reversed(inner), self.at(cut_m)]
        return Path(Point(x_m=corner.x_m, y_m=corner.y_m) for corner in corners)

    def stretch(self, point: Point) -> None:
        """Have the last segment reach further, straight on to a point."""
        self._vertices.pop()
        self.extend(point)

    def learn(self, first: int, vertices: Sequence[Vertex]) -> None:
        """Take over what another robot says of its path, from the vertex with index `first` on.

        What is known stays as it is, but that the last segment may reach further; and what does not join on
        to it waits until it is told again.
        """
        if first > len(self):
            return
        last = len(self) - 1
        if first <= last < first + len(vertices) and vertices[last - first].s_m > self.end_m:
            self._vertices[last] = vertices[last - first]
        self._vertices.extend(vertices[len(self) - first :])

    def told_from(self, first: int, most: int) -> tuple[Vertex, ...]:
        """At most so many vertices, from the one with index `first` on."""
        return tuple(self._vertices[first : first + most])

    def next_vertex(self, s_m: float) -> int:
        """Index of the first vertex beyond an arc length; the number of vertices where there is none."""
        return bisect_right(self._vertices, s_m, key=lambda vertex: vertex.s_m)

    def at(self, s_m: float) -> Point:
        """The place at an arc length, held to the path's ends."""
        index = min(max(self.next_vertex(s_m), 1), len(self) - 1)
        if index == 0:
            return Point(x_m=self._vertices[0].x_m, y_m=self._vertices[0].y_m)
        start, end = self._vertices[index - 1], self._vertices[index]
        length = end.s_m - start.s_m
        share = min(max((s_m - start.s_m) / length, 0.0), 1.0) if length > 0.0 else 1.0
        return Point(
            x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m)
        )

    def between(self, from_m: float, to_m: float) -> Floats:
        """The corners (n, 2) of the part between two arc lengths, both ends included; n >= 2."""
        after = self.next_vertex(from_m)
        inner = [vertex for vertex in self._vertices[after : self.next_vertex(to_m)] if vertex.s_m < to_m]
        corners: list[Point | Vertex] = [self.at(from_m), *inner, self.at(max(from_m, to_m))]
        return np.array([(corner.x_m, corner.y_m) for corner in corners])
