"""A grid of square cells for guidance: distances to points and lines, and a graph of cells."""

import math
from dataclasses import dataclass
from itertools import pairwise
from weakref import WeakValueDictionary

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.sparse import csr_array

from protocol.arrays import Flags, Floats, Indices, off_segments

POINTS_AT_ONCE = 64  # around them, some 150 kB of distances: those of all hits of a scan leave the cache
FINE = 4  # parts of a cell, each way: points in the same part are equal to guidance


@dataclass(frozen=True, slots=True)
class Grid:
    """Square cells over a rectangle [m; world frame]."""

    low: Floats
    """The lower left corner (2,)."""
    shape: tuple[int, int]
    cell_m: float

    @classmethod
    def over(cls, low: Floats, high: Floats, cell_m: float, *, cells_max: int) -> "Grid":
        """The grid over a rectangle; the cells are larger if there would be too many."""
        size = np.asarray(high - low, dtype=float)
        cell_m = max(cell_m, float(np.sqrt(size.prod() / cells_max)))
        width, height = np.maximum(np.ceil(size / cell_m), 1).astype(int).tolist()
        return cls(np.asarray(low, dtype=float), (width, height), cell_m)

    @property
    def high(self) -> Floats:
        """The upper right corner (2,)."""
        return np.asarray(self.low + np.array(self.shape) * self.cell_m)

    def has(self, points: Floats) -> Flags:
        """Whether each of the points (n, 2) is on the grid."""
        return np.asarray(((points >= self.low) & (points < self.high)).all(axis=1))

    def cells_of(self, points: Floats) -> Indices:
        """The cells (n, 2) of points; points off the grid get indices off the grid."""
        return np.floor((points - self.low) / self.cell_m).astype(np.intp)

    def centres_of(self, cells: Indices) -> Floats:
        """The centres (n, 2) of cells."""
        return np.asarray(self.low + (cells + 0.5) * self.cell_m)

    @property
    def fine_parts_max(self) -> int:
        """More than the number of any point on the grid."""
        return (self.shape[0] * FINE + 1) * (self.shape[1] * FINE + 1)

    def fine_parts(self, points: Floats) -> Indices:
        """A number (n,) for each point; points in the same part of a cell have the same number."""
        part = np.floor((points - self.low) / self.cell_m * FINE).astype(np.intp)
        return np.asarray(part[:, 0] * (self.shape[1] * FINE + 1) + part[:, 1])

    def lower_around(self, room: Floats, points: Floats, *, reach_m: float, less_m: float) -> None:
        """Lower `room` to the distance to the nearest of the points (n, 2), minus `less_m`."""
        reach = int(reach_m / self.cell_m + 0.5)  # in cells: the centres beyond are out of reach
        if len(points) == 0:
            return
        steps = np.arange(-reach, reach + 1)
        cells = self.cells_of(points)
        off_m = self.low + (cells + 0.5) * self.cell_m - points
        across_m2, up_m2 = (off_m.T[:, :, None] + steps * self.cell_m) ** 2
        low, high = cells.min(axis=0) - reach, cells.max(axis=0) + reach + 1
        width, height = (high - low).tolist()
        apart_m2 = np.full(width * height, np.inf)
        first = (cells - low) @ (height, 1)
        around = steps[:, None] * height + steps
        for index in range(0, len(points), POINTS_AT_ONCE):
            some = slice(index, index + POINTS_AT_ONCE)
            m2 = across_m2[some, :, None] + up_m2[some, None, :]
            np.minimum.at(apart_m2, (first[some, None, None] + around).ravel(), m2.ravel())
        (left, bottom), (right, top) = np.clip((low, high), 0, self.shape).tolist()
        here = room[left:right, bottom:top]
        there_m2 = apart_m2.reshape(width, height)[
            left - low[0] : right - low[0], bottom - low[1] : top - low[1]
        ]
        np.minimum(here, np.sqrt(there_m2) - less_m, out=here)

    def lower_along(self, room: Floats, corners: Floats, *, reach_m: float, less_m: float) -> None:
        """Lower `room` to the distance from a polyline (n, 2), minus `less_m`, at least within `reach_m`."""
        across, up = self.axes
        low, high = np.minimum(corners[:-1], corners[1:]), np.maximum(corners[:-1], corners[1:])
        first = np.clip(self.cells_of(low - reach_m), 0, self.shape).tolist()
        last = np.clip(self.cells_of(high + reach_m) + 1, 0, self.shape).tolist()
        for (left, bottom), (right, top), (start, end) in zip(first, last, pairwise(corners), strict=True):
            apart_m = off_segments(across[left:right, None], up[bottom:top], start, end)
            here = room[left:right, bottom:top]
            np.minimum(here, apart_m - less_m, out=here)

    def around(self, point: Floats, *, reach_m: float) -> tuple[Indices, Floats]:
        """The flat indices (n,) of the cells at most this far from a point (2,), and their distances (n,)."""
        left, bottom = np.clip(self.cells_of(point[None] - reach_m)[0], 0, self.shape).tolist()
        right, top = np.clip(self.cells_of(point[None] + reach_m)[0] + 1, 0, self.shape).tolist()
        across, up = self.axes
        off_m = np.hypot(across[left:right, None] - point[0], up[bottom:top] - point[1])
        x, y = np.nonzero(off_m <= reach_m)
        return (x + left) * self.shape[1] + (y + bottom), off_m[x, y]

    @property
    def axes(self) -> tuple[Floats, Floats]:
        """The coordinates x and y of the cells' centres."""
        x, y = (
            low + (np.arange(size) + 0.5) * self.cell_m
            for low, size in zip(self.low, self.shape, strict=True)
        )
        return x, y

    def off_border(self) -> Floats:
        """Distance of each cell's centre from the border of the grid."""
        along = ((np.arange(size) + 0.5) * self.cell_m for size in self.shape)
        ends = (
            np.minimum(here, size * self.cell_m - here) for here, size in zip(along, self.shape, strict=True)
        )
        return np.asarray(np.minimum.outer(*ends))


@dataclass(frozen=True, slots=True, weakref_slot=True)
class Lattice:
    """The cells of a grid as a graph without costs: each is joined to its eight neighbours.

    Floods over the same cells share one. It takes megabytes, and lives as long as somebody holds it.
    """

    joined: NDArray[np.int32]
    """The flat indices (cells, 8) of the neighbours; at the border a cell is joined to itself."""
    half_m: Floats
    """Half the distance to each neighbour (8,)."""

    @staticmethod
    def of(grid: Grid) -> "Lattice":
        """The lattice of a grid."""
        key = grid.shape, grid.cell_m
        if (lattice := _LATTICES.get(key)) is None:
            lattice = _LATTICES[key] = _lattice(*key)
        return lattice

    def __deepcopy__(self, _: object) -> "Lattice":
        return self  # nothing of it changes

    def graph(self, costs: Floats) -> csr_array:
        """The graph with these costs (cells, 8) of the edges from each cell."""
        first = np.arange(0, self.joined.size + 1, len(self.half_m), dtype=np.int32)
        cells = len(self.joined)
        return csr_array((costs.reshape(-1), self.joined.reshape(-1), first), shape=(cells, cells))

    def price(self, costs: Floats, price: Floats, changed: Indices | None = None) -> None:
        """Set the costs (cells, 8) of edges: length times the mean price of both cells (cells,).

        Closed cells cost infinity. `changed`: only the prices of these cells are others than before.
        """
        if changed is None:
            np.take(price, self.joined, out=costs, mode="clip")  # unbuffered; no index is out of bounds
            costs += price[:, None]  # in place: allocating memory for all costs takes longer than the sum
            costs *= self.half_m
            return
        concerned = np.zeros(len(price), dtype=np.bool_)
        concerned[self.joined[changed]] = True
        concerned[changed] = True
        rows = np.flatnonzero(concerned)
        costs[rows] = (price[self.joined[rows]] + price[rows, None]) * self.half_m


_LATTICES: WeakValueDictionary[tuple[tuple[int, int], float], Lattice] = WeakValueDictionary()


def _lattice(shape: tuple[int, int], cell_m: float) -> Lattice:
    cells = np.arange(math.prod(shape), dtype=np.int32)
    wide = np.pad(cells.reshape(shape), 1, constant_values=-1)
    around = np.delete(sliding_window_view(wide, (3, 3)).reshape(-1, 9), 4, axis=1)
    off_m = np.delete(np.hypot(*(np.indices((3, 3)) - 1)).ravel(), 4) * cell_m
    return Lattice(np.where(around < 0, cells[:, None], around), off_m / 2.0)
