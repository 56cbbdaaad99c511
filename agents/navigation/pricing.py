"""What it costs to drive through the cells of a grid, as a graph for Dijkstra's algorithm.

Rule 1: cells nearer to a hit than the robot with its clearance are closed. Driving near them costs more, so
        that ways keep off obstacles where there is room. Cells within half a cell of the limit stay open at
        a higher cost: guidance only ranks, and the certificate decides what may be driven.
Rule 2: a plan differs from the one before in a few cells. Only their prices, and the edges to and from them,
        are computed again; the others are the same to the last bit.
"""

import numpy as np
from scipy.sparse import csr_array

from agents.navigation.grid import Grid, Lattice
from protocol.arrays import Flags, Floats

COMFORT = 2.0  # next to closed ground a metre costs this much more than in the open
DOUBT = 20.0  # where a cell may be closed: a detour of 5 m is better than a way that ends at a gap
FELT_CELLS = 4.0  # within this of closed ground driving costs more; too narrow to close a way
FEW = 0.25  # share of the cells: where more have changed, it is faster to compute all


def is_open(room: Floats, cell_m: float) -> Flags:
    """Whether cells with this room (distance beyond the least one) are open."""
    return np.asarray(room > -cell_m / 2.0)


class Pricing:
    """The costs of one grid, as they were last asked for."""

    def __init__(self, grid: Grid) -> None:
        self._cell_m = grid.cell_m
        self._lattice = Lattice.of(grid)
        self._room = np.full(grid.shape[0] * grid.shape[1], np.nan)
        """The room of each cell for which the costs are; at first of none."""
        self._price = np.full(len(self._room), np.inf)
        self._graph = self._lattice.graph()

    def graph(self, room: Floats) -> csr_array:
        """The graph for this room of each cell; it is valid until the next call."""
        room = room.reshape(-1)
        changed = np.flatnonzero(room != self._room)
        prices = self._prices(room[changed])
        self._room[changed] = room[changed]
        is_other = prices != self._price[changed]
        changed = changed[is_other]
        self._price[changed] = prices[is_other]
        if len(changed) > FEW * len(room):
            self._lattice.price(self._graph, self._price)
        elif len(changed):
            self._lattice.price(self._graph, self._price, changed)
        return self._graph

    def _prices(self, room: Floats) -> Floats:
        """Cost per metre; infinite where a cell is closed (rule 1)."""
        felt = np.clip(1.0 - room / (FELT_CELLS * self._cell_m), 0.0, 1.0)
        price = 1.0 + COMFORT * felt + DOUBT * (room < 0.0)
        return np.where(is_open(room, self._cell_m), price, np.inf)
