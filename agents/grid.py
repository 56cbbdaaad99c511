"""A grid of square cells over the ground, as guidance uses it: distances into cells, and a graph of cells."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array

from protocol.arrays import Flags, Floats, Indices, distances_to_segments

FINE = 4  # two points in one of so many parts of a cell, each way, tell guidance the same
NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))  # each pair of cells once; the graph is undirected


@dataclass(frozen=True, slots=True)
class Grid:
    """Square cells over a rectangle [m; world frame]."""

    low: Floats
    """Its lower left corner (2,)."""
    shape: tuple[int, int]
    cell_m: float

    @classmethod
    def over(cls, low: Floats, high: Floats, cell_m: float, *, cells_max: int) -> "Grid":
        """The grid over a rectangle, with larger cells where there would be too many."""
        size = np.asarray(high - low, dtype=float)
        cell_m = max(cell_m, float(np.sqrt(size.prod() / cells_max)))
        width, height = np.maximum(np.ceil(size / cell_m), 1).astype(int).tolist()
        return cls(np.asarray(low, dtype=float), (width, height), cell_m)

    @property
    def high(self) -> Floats:
        """Its upper right corner (2,)."""
        return np.asarray(self.low + np.array(self.shape) * self.cell_m)

    def has(self, points: Floats) -> Flags:
        """Which points (n, 2) are on it."""
        return np.asarray(((points >= self.low) & (points < self.high)).all(axis=1))

    def cells_of(self, points: Floats) -> Indices:
        """The cells (n, 2) that points are in; those off the grid are in cells that there are not."""
        return np.floor((points - self.low) / self.cell_m).astype(np.intp)

    def centres_of(self, cells: Indices) -> Floats:
        """The middles (n, 2) of cells."""
        return np.asarray(self.low + (cells + 0.5) * self.cell_m)

    def fine_parts(self, points: Floats) -> Indices:
        """A number (n,) for each point, the same for points that are as good as one."""
        part = np.floor((points - self.low) / self.cell_m * FINE).astype(np.intp)
        return np.asarray(part[:, 0] * (self.shape[1] * FINE + 1) + part[:, 1])

    def lower_around(self, room: Floats, points: Floats, *, reach_m: float, less_m: float) -> None:
        """Make `room` in cells no more than the distance to any of the points (n, 2), less so much."""
        span = np.arange(-int(reach_m / self.cell_m) - 1, int(reach_m / self.cell_m) + 2)
        offset = np.stack(np.meshgrid(span, span, indexing="ij"), axis=-1).reshape(-1, 2)
        offset = offset[np.hypot(*offset.T) * self.cell_m <= reach_m + self.cell_m]
        cells = self.cells_of(points)[:, None, :] + offset[None, :, :]
        apart_m = np.hypot(*np.moveaxis(self.centres_of(cells) - points[:, None, :], -1, 0))
        inside = ((cells >= 0) & (cells < self.shape)).all(axis=-1)
        np.minimum.at(room, (cells[inside][:, 0], cells[inside][:, 1]), apart_m[inside] - less_m)

    def off_line(self, corners: Floats, *, reach_m: float) -> Floats:
        """Distance of each cell's middle from a polyline (n, 2); infinite beyond reach."""
        apart_m = np.full(self.shape, np.inf)
        for start, end in pairwise(corners):
            first = np.clip(self.cells_of(np.minimum(start, end)[None] - reach_m)[0], 0, self.shape)
            last = np.clip(self.cells_of(np.maximum(start, end)[None] + reach_m)[0] + 1, 0, self.shape)
            window = (slice(first[0], last[0]), slice(first[1], last[1]))
            cells = np.stack(np.meshgrid(*map(np.arange, first, last), indexing="ij"), axis=-1)
            here = distances_to_segments(self.centres_of(cells), start, end)
            apart_m[window] = np.minimum(apart_m[window], here)
        return apart_m

    def off_border(self) -> Floats:
        """Distance of each cell's middle from the grid's border."""
        along = ((np.arange(size) + 0.5) * self.cell_m for size in self.shape)
        ends = (
            np.minimum(here, size * self.cell_m - here) for here, size in zip(along, self.shape, strict=True)
        )
        return np.asarray(np.minimum.outer(*ends))

    def graph(self, is_open: Flags, price: Floats) -> csr_array:
        """The open cells as an undirected graph: each with its neighbours, at the mean price of both."""
        index = np.arange(is_open.size, dtype=np.int32).reshape(self.shape)
        rows, columns, costs = [], [], []
        for dx, dy in NEIGHBOURS:
            here, there = _shifted(self.shape, dx, dy)
            both = is_open[here] & is_open[there]
            rows.append(index[here][both])
            columns.append(index[there][both])
            costs.append((np.hypot(dx, dy) * self.cell_m / 2.0) * (price[here] + price[there])[both])
        ends = (np.concatenate(rows), np.concatenate(columns))
        return csr_array((np.concatenate(costs), ends), shape=(is_open.size, is_open.size))


def _shifted(shape: tuple[int, int], dx: int, dy: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """The cells that have a neighbour at (dx, dy), and those neighbours."""
    width, height = shape
    here_y = slice(max(-dy, 0), height - max(dy, 0))
    there_y = slice(max(dy, 0), height - max(-dy, 0))
    return (slice(0, width - dx), here_y), (slice(dx, width), there_y)
