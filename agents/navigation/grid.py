"""A grid of square cells for guidance: distances to points and lines, and a graph of cells."""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

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
        around = np.arange(2 * reach + 1)
        cells = self.cells_of(points)
        off_m = self.low + (cells + 0.5) * self.cell_m - points
        across_m2, up_m2 = (off_m.T[:, :, None] + (around - reach) * self.cell_m) ** 2
        # The border makes clipping unnecessary.
        wide_m2 = np.full((self.shape[0] + 2 * reach, self.shape[1] + 2 * reach), np.inf)
        first = cells @ (wide_m2.shape[1], 1)
        steps = around[:, None] * wide_m2.shape[1] + around
        for index in range(0, len(points), POINTS_AT_ONCE):
            some = slice(index, index + POINTS_AT_ONCE)
            apart_m2 = across_m2[some, :, None] + up_m2[some, None, :]
            np.minimum.at(wide_m2.reshape(-1), (first[some, None, None] + steps).ravel(), apart_m2.ravel())
        apart_m = np.sqrt(wide_m2[reach : reach + self.shape[0], reach : reach + self.shape[1]])
        np.minimum(room, apart_m - less_m, out=room)

    def off_line(self, corners: Floats, *, reach_m: float) -> Floats:
        """Distance of each cell's centre from a polyline (n, 2); infinite beyond `reach_m`."""
        apart_m = np.full(self.shape, np.inf)
        for start, end in pairwise(corners):
            first = np.clip(self.cells_of(np.minimum(start, end)[None] - reach_m)[0], 0, self.shape)
            last = np.clip(self.cells_of(np.maximum(start, end)[None] + reach_m)[0] + 1, 0, self.shape)
            window = (slice(first[0], last[0]), slice(first[1], last[1]))
            x, y = (
                low + (np.arange(*ends) + 0.5) * self.cell_m
                for low, *ends in zip(self.low, first, last, strict=True)
            )
            here = off_segments(x[:, None], y, start, end)
            apart_m[window] = np.minimum(apart_m[window], here)
        return apart_m

    def off_border(self) -> Floats:
        """Distance of each cell's centre from the border of the grid."""
        along = ((np.arange(size) + 0.5) * self.cell_m for size in self.shape)
        ends = (
            np.minimum(here, size * self.cell_m - here) for here, size in zip(along, self.shape, strict=True)
        )
        return np.asarray(np.minimum.outer(*ends))


@dataclass(frozen=True, slots=True)
class Lattice:
    """The cells of a grid as a graph without costs: each is joined to its eight neighbours."""

    joined: NDArray[np.int32]
    """The flat indices (cells, 8) of the neighbours; at the border a cell is joined to itself."""
    half_m: Floats
    """Half the distance to each neighbour (8,)."""

    @staticmethod
    def of(grid: Grid) -> "Lattice":
        """The lattice of a grid."""
        return _lattice(grid.shape, grid.cell_m)

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


@lru_cache(maxsize=2)  # the grid is often rebuilt over the same cells, when ground turns out to be free
def _lattice(shape: tuple[int, int], cell_m: float) -> Lattice:
    cells = np.arange(math.prod(shape), dtype=np.int32)
    wide = np.pad(cells.reshape(shape), 1, constant_values=-1)
    around = np.delete(sliding_window_view(wide, (3, 3)).reshape(-1, 9), 4, axis=1)
    off_m = np.delete(np.hypot(*(np.indices((3, 3)) - 1)).ravel(), 4) * cell_m
    return Lattice(np.where(around < 0, cells[:, None], around), off_m / 2.0)
