"""A path: the polyline that a robot drives, with arc length along it. It grows only at its end."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from typing import Self

import numpy as np

from protocol.arrays import Floats
from protocol.frames import Point, Vertex

Place = tuple[float, float]  # x, y [m; world frame]

THERE_M = 1e-6  # a place this near to an arc length has reached it: rounding of sums of metres
ON_LINE_M = 1e-9  # a point this near to a line is on it: rounding of sums of metres


def straightened(points: Sequence[Point]) -> list[Point]:
    """The corners of a polyline: points on the straight line between their neighbours are left out."""
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
    # If the end equals the start, no point is between them.
    return length_m > 0.0 and between and beside_m <= ON_LINE_M * length_m


def _is_next(vertex: Vertex, following: Vertex) -> bool:
    length_m = math.hypot(following.x_m - vertex.x_m, following.y_m - vertex.y_m)
    return abs(following.s_m - vertex.s_m - length_m) <= THERE_M


def _is_straight_on(before: Vertex, last: Vertex, further: Vertex) -> bool:
    """Whether a path whose last vertex is moved further keeps the ground that it had."""
    return further.s_m >= last.s_m and _is_next(before, further) and _is_next(last, further)


class Path:
    """Vertices with arc length from the first one [m; world frame]."""

    def __init__(self, points: Iterable[Point]) -> None:
        self._vertices: list[Vertex] = []
        self._arcs_m: list[float] = []  # of the vertices, for lookup
        for point in points:
            self.extend(point)

    @classmethod
    def told(cls, vertices: Iterable[Vertex]) -> Self:
        """A path with the arc lengths as they were told."""
        path = cls(())
        path._add(*vertices)
        return path

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
        self._add(Vertex(x_m=point.x_m, y_m=point.y_m, s_m=s_m))
        return self._vertices[-1]

    def _add(self, *vertices: Vertex) -> None:
        self._vertices.extend(vertices)
        self._arcs_m.extend(vertex.s_m for vertex in vertices)

    def _drop_last(self) -> None:
        del self._vertices[-1], self._arcs_m[-1]

    def reversed(self, cut_m: float, end_m: float) -> "Path":
        """The part between two arc lengths, reversed: its arc length 0 is at `end_m` of this path."""
        inner = [vertex for vertex in self._vertices if cut_m < vertex.s_m < end_m]
        corners: list[Point | Vertex] = [self.at(end_m), *reversed(inner), self.at(cut_m)]
        return Path(Point(x_m=corner.x_m, y_m=corner.y_m) for corner in corners)

    def stretch(self, point: Point) -> None:
        """Extend the last segment straight on to a point."""
        self._drop_last()
        self.extend(point)

    def copy(self) -> "Path":
        """The same vertices, with the same arc lengths."""
        path = Path(())
        path.learn(0, self._vertices)
        return path

    def fits(self, first: int, vertices: Sequence[Vertex]) -> bool:
        """Whether vertices of another robot's path, from index `first` on, can be of this path.

        Known vertices have to be the same; the last one may have moved straight on. Each further one has the
        arc length that its coordinates give. What lies beyond a gap is not known yet, and fits.
        """
        known = self._vertices
        if first > len(known):
            return True
        last = len(known) - 1
        before = known[first - 1] if first > 0 else None
        for index, vertex in enumerate(vertices, start=first):
            if index > last:
                if before is None or not _is_next(before, vertex):
                    return False
            elif vertex != known[index] and (
                index < last or before is None or not _is_straight_on(before, known[index], vertex)
            ):
                return False
            before = vertex
        return True

    def learn(self, first: int, vertices: Sequence[Vertex]) -> None:
        """Add another robot's vertices of its path, from the vertex with index `first` on.

        Known vertices stay, but the last segment may become longer. Vertices beyond a gap are ignored until
        they are sent again.
        """
        if first > len(self):
            return
        last = len(self) - 1
        if first <= last < first + len(vertices) and vertices[last - first].s_m > self.end_m:
            self._drop_last()
        if first + len(vertices) > len(self):  # most messages tell only the last vertex, which is known
            self._add(*vertices[len(self) - first :])

    def told_from(self, first: int, most: int) -> tuple[Vertex, ...]:
        """At most `most` vertices, from the one with index `first` on."""
        return tuple(self._vertices[first : first + most])

    def next_vertex(self, s_m: float) -> int:
        """Index of the first vertex beyond an arc length; the number of vertices where there is none."""
        return bisect_right(self._arcs_m, s_m)

    def at(self, s_m: float) -> Point:
        """The point at an arc length, limited to the path's ends."""
        x_m, y_m = self._place_at(s_m)
        return Point(x_m=x_m, y_m=y_m)

    def _place_at(self, s_m: float) -> Place:
        index = min(max(self.next_vertex(s_m), 1), len(self._vertices) - 1)
        end = self._vertices[index]
        if index == 0:
            return end.x_m, end.y_m
        start = self._vertices[index - 1]
        length = end.s_m - start.s_m
        share = min(max((s_m - start.s_m) / length, 0.0), 1.0) if length > 0.0 else 1.0
        return start.x_m + share * (end.x_m - start.x_m), start.y_m + share * (end.y_m - start.y_m)

    def corners(self, from_m: float, to_m: float) -> list[Place]:
        """The corners of the part between two arc lengths, both ends included: two or more."""
        inner = self._vertices[self.next_vertex(from_m) : bisect_left(self._arcs_m, to_m)]
        between = [(vertex.x_m, vertex.y_m) for vertex in inner]
        return [self._place_at(from_m), *between, self._place_at(max(from_m, to_m))]

    def between(self, from_m: float, to_m: float) -> Floats:
        """The same corners as an array (n, 2)."""
        return np.array(self.corners(from_m, to_m))
