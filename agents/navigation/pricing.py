"""What it costs to drive through the cells of a grid, and from them to a goal, by Dijkstra's algorithm.

Rule 1: cells nearer to a hit than the robot with its clearance are closed. Driving near them costs more, so
        that ways keep off obstacles where there is room. Cells within half a cell of the limit stay open at
        a higher cost: guidance only ranks, and the certificate decides what may be driven.
Rule 2: a plan differs from the one before in a few cells. Only their prices, and the edges to and from them,
        are computed again; the others are the same to the last bit.
Rule 3: a way across a changed price costs at least as much as the cheapest cell there. So all costs to the
        goal up to that are as before, and are kept.
Rule 4: costs are computed in order, from where they are known to as far as is asked.
Rule 5: cells take megabytes, and follow from the hits and the closed spots of their map. So a map that is not
        used gives them up, and has them made again when it is asked.
"""

from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from agents.navigation.grid import Grid, Lattice
from protocol.arrays import Flags, Floats, Indices

COMFORT = 2.0  # next to closed ground a metre costs this much more than in the open
DOUBT = 20.0  # where a cell may be closed: a detour of 5 m is better than a way that ends at a gap
FELT_CELLS = 4.0  # within this of closed ground driving costs more; too narrow to close a way
COST_M_MAX = 1e9  # more than any way; edges of infinite cost are skipped
FEW = 0.25  # share of the cells: where more have changed, it is faster to compute all


def is_open(room: Floats, cell_m: float) -> Flags:
    """Whether cells with this room (distance beyond the least one) are open."""
    return np.asarray(room > -cell_m / 2.0)


class Pricing:
    """The prices of the cells of one grid, as they were last asked for."""

    def __init__(self, grid: Grid) -> None:
        self._cell_m = grid.cell_m
        self._lattice = Lattice.of(grid)
        self._room = np.full(grid.shape[0] * grid.shape[1], np.nan)
        """The room of each cell for which the prices are; at first of none."""
        self._price = np.full(len(self._room), np.inf)

    def update(self, costs: Floats, room: Floats) -> Indices:
        """Turn the costs (cells, 8) of edges, infinite at first, into those for this room of each cell.

        Returns:
            The cells (n,) whose prices have changed.
        """
        room = room.reshape(-1)
        changed: Indices = np.flatnonzero(room != self._room)
        prices = self._prices(room[changed])
        self._room[changed] = room[changed]
        is_other = prices != self._price[changed]
        changed = changed[is_other]
        self._price[changed] = prices[is_other]
        if len(changed) > FEW * len(room):
            self._lattice.price(costs, self._price)
        elif len(changed):
            self._lattice.price(costs, self._price, changed)
        return changed

    def _prices(self, room: Floats) -> Floats:
        """Cost per metre; infinite where a cell is closed (rule 1)."""
        felt = np.clip(1.0 - room / (FELT_CELLS * self._cell_m), 0.0, 1.0)
        price = 1.0 + COMFORT * felt + DOUBT * (room < 0.0)
        return np.where(is_open(room, self._cell_m), price, np.inf)


class Flood:
    """The least costs from the cells of a grid to its sources, as far as they were asked for."""

    def __init__(self, grid: Grid) -> None:
        self._lattice = Lattice.of(grid)
        cells, edges = self._lattice.joined.shape
        # One node more than cells: its edges lead to the cells from which a flood goes on.
        self._ends = np.append(self._lattice.joined.reshape(-1), np.zeros(cells, dtype=np.int32))
        self._first = np.append(np.arange(0, cells * edges + 1, edges, dtype=np.int32), np.int32(0))
        self._weights = np.full(cells * (edges + 1), np.inf)
        self._shape = grid.shape
        self._pricing = Pricing(grid)
        self._dearest_m = (1.0 + COMFORT + DOUBT) * 2.0 * float(self._lattice.half_m.max())
        self._sources = np.empty(0, dtype=np.intp)
        self._known_m = np.full(cells, np.inf)
        self.reached_m = -np.inf
        """All costs up to this are known; infinite: all are."""

    @property
    def _costs(self) -> Floats:
        """The costs (cells, 8) of the edges between cells."""
        joined = self._lattice.joined
        return self._weights[: joined.size].reshape(joined.shape)

    def begin(self, room: Floats, sources: Indices) -> None:
        """Ask for the costs to these cells (n,), with this room of each cell; what still holds is kept."""
        changed = self._pricing.update(self._costs, room)
        if not np.array_equal(sources, self._sources):
            self._sources, self.reached_m = sources, -np.inf
        elif len(changed):
            there_m = min(self._known_m[self._lattice.joined[changed]].min(), self._known_m[changed].min())
            self.reached_m = min(self.reached_m, float(there_m))
        self._known_m = np.where(self._known_m <= self.reached_m, self._known_m, np.inf)

    def up_to(self, limit_m: float) -> Floats:
        """The costs (cells,), at least all up to this; the others are infinite (rule 4)."""
        if limit_m > self.reached_m:
            cells, starts_m = self._next()
            if len(cells):
                found_m = self._from(cells, starts_m, limit_m)
                self._known_m = np.minimum(self._known_m, found_m)
            self.reached_m = limit_m if len(cells) and limit_m < COST_M_MAX else np.inf
        return self._known_m

    def alone(self, sources: Indices) -> Floats:
        """The costs (cells,) to other cells (n,), which are not kept."""
        graph = self._lattice.graph(self._costs)
        return np.asarray(dijkstra(graph, indices=sources, min_only=True, limit=COST_M_MAX))

    def _next(self) -> tuple[Indices, Floats]:
        """The cells (n,) beside those that are known, and the least costs (n,) by way of these."""
        is_known = np.isfinite(self._known_m)
        if not is_known.any():
            return self._sources, np.zeros(len(self._sources))
        is_rim = is_known & (self._known_m > self.reached_m - self._dearest_m)
        cells = np.flatnonzero(_spread(is_rim.reshape(self._shape)).reshape(-1) & ~is_known)
        starts_m = (self._known_m[self._lattice.joined[cells]] + self._costs[cells]).min(axis=1)
        is_open = np.isfinite(starts_m)
        return cells[is_open], starts_m[is_open]

    def _from(self, cells: Indices, starts_m: Floats, limit_m: float) -> Floats:
        """The costs (cells,) up to a limit of ways that begin at these cells and stay off what is known."""
        costs, joined, nodes = self._costs, self._lattice.joined, len(self._known_m) + 1
        before = costs[cells]
        costs[cells] = np.where(np.isfinite(self._known_m[joined[cells]]), np.inf, before)
        edges = slice(costs.size, costs.size + len(cells))
        self._ends[edges], self._weights[edges], self._first[-1] = cells, starts_m, edges.stop
        arrays = self._weights[: edges.stop], self._ends[: edges.stop], self._first
        graph, source = csr_array(arrays, shape=(nodes, nodes)), np.array([nodes - 1])
        found_m = dijkstra(graph, indices=source, limit=limit_m)
        costs[cells] = before
        return np.asarray(found_m[0, :-1])


class Cells:
    """What is known of the cells of a grid."""

    def __init__(self, grid: Grid, *, keep_in_m: float | None) -> None:
        """Without a hit; `keep_in_m`: how far to keep off the border of the grid, None: not at all."""
        self._grid = grid
        self._known = np.zeros(grid.fine_parts_max, dtype=np.bool_)
        self.room = np.full(grid.shape, np.inf) if keep_in_m is None else grid.off_border() - keep_in_m
        """Distance of each cell's centre from what is nearest to it, beyond the least one [m]."""

    @cached_property
    def flood(self) -> Flood:
        """Made when it is first asked for: it takes most of the memory, and few robots plan."""
        return Flood(self._grid)

    def know(self, hits: Floats) -> Floats:
        """Note hits (n, 2) on the grid; returns those (m, 2) that are equal to none that was noted before."""
        parts = self._grid.fine_parts(hits)
        is_new = ~self._known[parts]
        self._known[parts] = True
        return hits[is_new]

    def keep_off(self, points: Floats, keep_m: float) -> None:
        """Lower the room around points (n, 2) from which a robot keeps so far."""
        reach_m = keep_m + FELT_CELLS * self._grid.cell_m
        self._grid.lower_around(self.room, points, reach_m=reach_m, less_m=keep_m)


def _spread(flags: Flags) -> Flags:
    """The flags of cells (x, y), also set on all eight neighbours."""
    wide = flags.copy()
    wide[1:] |= flags[:-1]
    wide[:-1] |= flags[1:]
    both = wide.copy()
    both[:, 1:] |= wide[:, :-1]
    both[:, :-1] |= wide[:, 1:]
    return both
