"""One connected piece of free ground: all places that a disc can reach from one place, found on a grid.

Rule 1: the grid is conservative: it may miss a way that barely fits.
Rule 2: scipy is loaded when a piece is asked for. That takes a third of a launcher's and of a world's start,
        and most scenarios draw no places.
Rule 3: the grid is measured tile by tile, against the obstacles near to the tile: a map has thousands.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from protocol.arrays import Flags, Floats, Indices
from protocol.mission import Bounds
from world.geometry.clearance import clearance
from world.geometry.shapes import Ground

CELLS = 4.0  # per distance to keep: ways that are 20 % wider than necessary are found
CELLS_MAX = 400_000  # 1 s to 2 s of work; wider bounds get larger cells, which need wider ways
TILE_CELLS = 32  # along each side; near to such a tile are few obstacles


@dataclass(frozen=True)
class Piece:
    """The cells of the piece."""

    low_m: Floats
    """The lower left corner of the first cell (2,) [m; world frame]."""
    cell_m: float
    cells: Flags
    """`(columns, rows)`, along x and along y."""

    def holds(self, x_m: float, y_m: float) -> bool:
        """Whether a place is in one of its cells."""
        column, row = np.floor((np.array((x_m, y_m)) - self.low_m) / self.cell_m).astype(int)
        inside = 0 <= column < self.cells.shape[0] and 0 <= row < self.cells.shape[1]
        return bool(inside and self.cells[column, row])


def piece_of(
    ground: Ground, bounds: Bounds, *, at_m: tuple[float, float] | None, hull_m: float, clear_m: float
) -> Piece:
    """The piece nearest to a place, or the largest if no place is given; empty if nothing is free.

    Args:
        ground: the obstacles.
        bounds: the rectangle that no hull may leave.
        at_m: the place [m; world frame].
        hull_m: a robot's radius.
        clear_m: least distance of a centre from an obstacle.
    """
    from scipy import ndimage  # noqa: PLC0415 - late, by rule 2

    low_m = np.array([bounds.x_m_min, bounds.y_m_min])
    size_m = np.array([bounds.x_m_max, bounds.y_m_max]) - low_m
    cell_m = max(clear_m / CELLS, math.sqrt(float(np.prod(size_m)) / CELLS_MAX))
    columns, rows = np.ceil(size_m / cell_m).astype(int)
    middles = low_m + cell_m * (np.indices((columns, rows)).reshape(2, -1).T + 0.5)
    # Half a cell, or half a diagonal, is added, so that the whole area of a free cell is free.
    inner = np.minimum(middles - low_m, low_m + size_m - middles).min(axis=1) >= hull_m + cell_m / 2.0
    places, free = middles.reshape(columns, rows, 2), inner.reshape(columns, rows)
    for tile in product(*(range(0, count, TILE_CELLS) for count in free.shape)):
        cut = tuple(slice(first, first + TILE_CELLS) for first in tile)
        free[cut] &= _are_clear(ground, places[cut], clear_m + cell_m / math.sqrt(2.0))
    labels = np.asarray(ndimage.label(free)[0], dtype=np.intp)
    return Piece(low_m, cell_m, free & (labels == _chosen(labels, middles, at_m)))


def _chosen(labels: Indices, middles: Floats, at_m: tuple[float, float] | None) -> int:
    """The label of the requested piece."""
    flat = labels.reshape(-1)
    free = np.flatnonzero(flat)
    if len(free) == 0:
        return 0
    if at_m is None:
        return int(np.bincount(flat[free]).argmax())
    return int(flat[free[np.hypot(*(middles[free] - at_m).T).argmin()]])


def _are_clear(ground: Ground, places: Floats, clear_m: float) -> Flags:
    """Which of the places (k, l, 2) of a tile are at least so far from all obstacles."""
    points = places.reshape(-1, 2)
    near = ground.within(points.min(axis=0) - clear_m, points.max(axis=0) + clear_m)
    return np.asarray(clearance(near, points, points) >= clear_m).reshape(places.shape[:2])
