"""Guidance: where to go. It remembers every hit; ground that nobody has seen counts as free.

The map is a grid. Cells nearer to a hit than the robot with its clearance are closed; near them
driving costs more, so that ways keep off obstacles where there is room. The cost-to-go of every cell
comes from one Dijkstra run from the goal. Guidance only ranks; what may be driven is the
certificate's to say.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from protocol.arrays import Floats, Indices
from protocol.mission import Bounds

CELLS_MAX = 250_000  # 500 x 500: a plan stays within some 0.2 s
COMFORT = 2.0  # next to closed ground a metre costs this much more than in the open
NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))  # each pair of cells once; the graph is undirected


@dataclass(frozen=True)
class CostToGo:
    """Cost from every cell to the goal [m]; infinite where there is no way."""

    cells: Floats
    low: Floats
    cell_m: float

    def at(self, points: Floats) -> Floats:
        """Cost-to-go at points (n, 2), interpolated; infinite next to closed ground."""
        where = ((points - self.low) / self.cell_m - 0.5).T
        cost = map_coordinates(self.cells, where, order=1, mode="constant", cval=np.inf)
        return np.where(np.isnan(cost), np.inf, cost)  # 0 * inf, where a closed cell has no weight


class Map:
    """What the leader has seen of the region so far."""

    def __init__(self, bounds: Bounds, *, cell_m: float) -> None:
        self._low = np.array([bounds.x_m_min, bounds.y_m_min])
        size = np.array([bounds.x_m_max, bounds.y_m_max]) - self._low
        self._cell_m = max(cell_m, float(np.sqrt(size.prod() / CELLS_MAX)))
        self._hit = np.zeros(np.maximum(np.ceil(size / self._cell_m), 1).astype(int), dtype=np.bool_)

    def remember(self, hit_points: Floats) -> None:
        """Add hits (n, 2) [m; world frame]; what is outside the bounds is no concern of ours."""
        cells = np.floor((hit_points - self._low) / self._cell_m).astype(int)
        cells = cells[((cells >= 0) & (cells < self._hit.shape)).all(axis=1)]
        self._hit[cells[:, 0], cells[:, 1]] = True

    def cost_to_go(self, goal: Floats, *, tolerance_m: float, keep_m: float, keep_in_m: float) -> CostToGo:
        """Cost from everywhere to the goal, `keep_m` off all hits and `keep_in_m` inside the bounds.

        Where the goal itself is closed, any open cell within its tolerance will do.
        """
        off_hits = distance_transform_edt(~self._hit) * self._cell_m if self._hit.any() else np.inf
        off_bounds = np.minimum.outer(*(self._to_ends_m(size) for size in self._hit.shape))
        room = np.minimum(off_hits - keep_m, off_bounds - keep_in_m)
        cells = _dijkstra(room, self._cell_m, self._sources(room, goal, tolerance_m))
        return CostToGo(cells, self._low, self._cell_m)

    def _to_ends_m(self, size: int) -> Floats:
        along = np.arange(size) + 0.5
        return np.asarray(np.minimum(along, size - along) * self._cell_m)

    def _sources(self, room: Floats, goal: Floats, tolerance_m: float) -> Indices:
        centres = (np.indices(room.shape).reshape(2, -1).T + 0.5) * self._cell_m + self._low
        off_goal = np.hypot(*(centres - goal).T)
        open_cells = np.flatnonzero(room.ravel() > 0.0)
        near = open_cells[off_goal[open_cells] <= max(tolerance_m, self._cell_m)]
        at_goal = near[off_goal[near] <= self._cell_m]
        return np.asarray(at_goal if len(at_goal) else near)


def _dijkstra(room: Floats, cell_m: float, sources: Indices) -> Floats:
    """Cost of every cell from the nearest source, over eight neighbours."""
    if len(sources) == 0:
        return np.full(room.shape, np.inf)
    is_open = room > 0.0
    margin = 4.0 * cell_m  # four cells: enough to be felt, too little to close a way
    price = 1.0 + COMFORT * np.clip(1.0 - room / margin, 0.0, 1.0)
    index = np.arange(room.size).reshape(room.shape)
    rows, columns, costs = [], [], []
    for dx, dy in NEIGHBOURS:
        here, there = _shifted(room.shape, dx, dy)
        both = is_open[here] & is_open[there]
        rows.append(index[here][both])
        columns.append(index[there][both])
        costs.append((np.hypot(dx, dy) * cell_m / 2.0) * (price[here] + price[there])[both])
    graph = coo_array(
        (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(room.size, room.size)
    ).tocsr()
    cost = dijkstra(graph, directed=False, indices=sources, min_only=True)
    return np.asarray(cost.reshape(room.shape))


def _shifted(shape: tuple[int, ...], dx: int, dy: int) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """The cells that have a neighbour at (dx, dy), and those neighbours."""
    width, height = shape
    here_y = slice(max(-dy, 0), height - max(dy, 0))
    there_y = slice(max(dy, 0), height - max(-dy, 0))
    return (slice(0, width - dx), here_y), (slice(dx, width), there_y)
