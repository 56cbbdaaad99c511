"""A textbook grid planner, for comparison: what the leader's plans are measured against.

It plans on the leader's scans and on a grid with the same cells: a distance transform of the cells that were
hit, the eight-neighbour graph of the cells far enough away, and Dijkstra's costs from the goal to them.
It knows clearance only by whole cells, and certifies no motion.
"""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from agents.navigation.grid import Grid
from agents.navigation.guidance import CELL_M_MAX, CELLS_MAX, CELLS_PER_KEEP
from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, Indices
from protocol.mission import Mission

HALF = (
    (0, 1),
    (1, 0),
    (1, 1),
    (1, -1),
)  # half of the eight neighbours, so that each pair of cells comes once


class Textbook:
    """The planner and its memory of scans, for a mission with a goal."""

    def __init__(self, mission: Mission) -> None:
        assert mission.goal is not None, "the caller has checked"
        self._mission = mission
        self._goal = np.array([mission.goal.x_m, mission.goal.y_m])
        self._hits = np.empty((0, 2))

    def remember(self, view: View) -> None:
        """Remember the hits of a scan."""
        self._hits = np.concatenate([self._hits, view.hit_points])

    def plan(self, view: View) -> Floats:
        """Remember the hits of a scan; returns the cost from every cell to the goal [m]."""
        self.remember(view)
        grid = self._grid(view.position)
        x, y = grid.cells_of(self._hits[grid.has(self._hits)]).T
        free = np.ones(grid.shape, dtype=np.bool_)
        free[x, y] = False
        is_open = distance_transform_edt(free) * grid.cell_m >= self._mission.obstacle_keep_m
        goal = np.clip(grid.cells_of(self._goal[None])[0], 0, np.array(grid.shape) - 1)
        source = np.ravel_multi_index(goal[:, None], grid.shape)
        cost = dijkstra(_graph(is_open, grid.cell_m), directed=False, indices=source)
        return np.asarray(cost.reshape(grid.shape))

    def _grid(self, position: Floats) -> Grid:
        """The leader's grid: over the bounds or, without bounds, over all hits and the goal."""
        cell_m = min(CELL_M_MAX, self._mission.obstacle_keep_m / CELLS_PER_KEEP)
        bounds = self._mission.bounds
        if bounds is not None:
            low, high = (bounds.x_m_min, bounds.y_m_min), (bounds.x_m_max, bounds.y_m_max)
            return Grid.over(np.array(low), np.array(high), cell_m, cells_max=CELLS_MAX)
        known, margin_m = np.vstack([self._hits, self._goal, position]), self._mission.range_m_max
        return Grid.over(
            known.min(axis=0) - margin_m, known.max(axis=0) + margin_m, cell_m, cells_max=CELLS_MAX
        )


def _graph(is_open: Flags, cell_m: float) -> csr_array:
    index = np.arange(is_open.size).reshape(is_open.shape)
    width, height = is_open.shape
    pairs: list[Indices] = []
    costs: list[Floats] = []
    for dx, dy in HALF:
        here = (slice(0, width - dx), slice(max(-dy, 0), height - max(dy, 0)))
        there = (slice(dx, width), slice(max(dy, 0), height - max(-dy, 0)))
        both = is_open[here] & is_open[there]
        pairs.append(np.stack([index[here][both], index[there][both]]))
        costs.append(np.full(int(both.sum()), np.hypot(dx, dy) * cell_m))
    ends = np.concatenate(pairs, axis=1)
    return csr_array((np.concatenate(costs), (ends[0], ends[1])), shape=(is_open.size, is_open.size))
