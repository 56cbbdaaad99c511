"""Guidance: ranks places by their cost to the goal. It remembers every hit; unseen ground counts as free.

Rule 1: driving costs more near hits, and cells that are too near are closed (`agents/navigation/pricing.py`).
Rule 2: the cost-to-go of every cell comes from a Dijkstra run from the goal. It ends soon behind the robot.
        It begins where the last plan's costs end to hold: what is new is most often near the robot.
Rule 3: if the certificate refuses the grid's way, the spot is closed. It is closed for good, unless robots or
        moving obstacles may be the reason.
Rule 4: where obstacles move, ground that is seen to be free is free, even if a hit was remembered there.
Rule 5: where the region has no bounds, the grid grows with what has been seen. Another robot may lie: if its
        hits would make cells too large to plan with, those outside the grid are left out.
Rule 6: a robot that neither leads nor joins keeps what its map remembers, but not its cells
        (`agents/navigation/pricing.py`).
"""

import zlib
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from agents.navigation.grid import Grid, Lattice
from agents.navigation.pricing import COST_M_MAX, Cells, Flood, is_open
from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, Indices
from protocol.mission import Mission
from protocol.wire.view import SEEN_BYTES_MAX

CELL_M_MAX = 0.05
CELLS_PER_KEEP = 3.0  # 4 found no more ways and saved no steps on 117 scenes, 75 of them near-critical
CELLS_MAX = 250_000  # 500 x 500: a plan stays within some 0.2 s
SPOT_KEEPS = 0.5  # size of a closed spot: more than the doubtful cells of a gap
PACKED_M = 0.005  # places that are handed over are rounded to this: a tenth of a cell
PLACES_MAX = 200_000  # unpacked from another robot's map
DETOUR = 1.3  # most ways cost at most this times the straight line: all of 26 on BARN
GROWN = 1.1  # a way cost at most this times what was thought in 47 of 87 plans, and `DETOUR` times that in 77
LEAST_M = 1.0  # a shorter flood saves nothing


@dataclass(frozen=True)
class CostToGo:
    """Cost from each cell to the goal [m]; infinite where there is no way."""

    grid: Grid
    cells: Floats

    @cached_property
    def _wide(self) -> Floats:
        """The costs with a border, two wide: around a point off the grid all cells are closed."""
        wide = np.full((self.cells.shape[0] + 4, self.cells.shape[1] + 4), np.inf)
        wide[2:-2, 2:-2] = self.cells
        return wide

    @cached_property
    def _corners(self) -> Indices:
        """How far in memory the four cells around a point are from the first of them (2, 2, 1)."""
        across = self._wide.shape[1]
        return np.array([[[0], [1]], [[across], [across + 1]]])

    def at(self, points: Floats) -> Floats:
        """Cost-to-go at points (n, 2) over the best of the four cells around; infinite if all are closed."""
        wide, cell_m = self._wide, self.grid.cell_m
        where = (points - self.grid.low) / cell_m + 1.5
        first = np.minimum(np.fmax(np.floor(where), 0.0), (wide.shape[0] - 2, wide.shape[1] - 2))
        x, y = (where - first).T  # in cells, from the cell before
        x2, y2 = np.array((x, x - 1.0)) ** 2, np.array((y, y - 1.0)) ** 2
        off_m = np.sqrt(x2[:, None] + y2) * cell_m
        cells = (first @ (wide.shape[1], 1.0)).astype(np.intp) + self._corners
        return np.asarray((off_m + wide.reshape(-1)[cells]).min(axis=(0, 1)))

    def places(self, cost_m: float, near: Floats, *, within_m: float) -> Floats:
        """The cells (n, 2) that cost at most this, in a square around a place (2,)."""
        reach_m = np.array([within_m, within_m])
        first, last = self.grid.cells_of(np.stack([near - reach_m, near + reach_m]))
        first = np.clip(first, 0, self.cells.shape)
        last = np.clip(last + 1, first, self.cells.shape)
        found = np.nonzero(self.cells[first[0] : last[0], first[1] : last[1]] <= cost_m)
        return self.grid.centres_of(np.stack(found, axis=-1) + first)

    def place_at(self, cost_m: float) -> Floats | None:
        """A place (2,) with this cost, or with the highest cost there is; None if there is no other place."""
        cost = np.where(np.isfinite(self.cells), self.cells, -1.0)
        enough = np.where(cost >= cost_m, cost, np.inf)
        best = np.argmin(enough) if np.isfinite(enough).any() else np.argmax(cost)
        if cost.flat[best] <= 0.0:
            return None
        cell = np.array(np.unravel_index(int(best), cost.shape), dtype=np.intp)
        return np.asarray(self.grid.centres_of(cell[None])[0])

    def way_from(self, point: Floats, *, cells_max: int) -> Floats:
        """The first cells of the way to the goal (n, 2); empty where there is none."""
        x, y = np.clip(self.grid.cells_of(point[None])[0], 0, np.array(self.cells.shape) - 1).tolist()
        way: list[tuple[int, int]] = []
        here_m = np.inf
        while len(way) < cells_max:
            around = self._wide[x + 1 : x + 4, y + 1 : y + 4]
            lowest = int(around.argmin())
            if not (next_m := around.item(lowest)) < here_m:
                break
            here_m, x, y = next_m, x + lowest // 3 - 1, y + lowest % 3 - 1
            way.append((x, y))
        return self.grid.centres_of(np.array(way, dtype=np.intp).reshape(-1, 2))


def shown_free(places: Floats, view: View, *, short_m: float) -> Flags:
    """The places (n, 2) that a scan shows to be free: at least `short_m` short of what it hit."""
    off = places - view.position
    rays = len(view.ranges_m)
    ray = (np.arctan2(off[:, 1], off[:, 0]) + np.pi) / (2.0 * np.pi) * rays
    first = np.floor(ray).astype(np.intp) % rays
    free_m = np.minimum(view.ranges_m[first], view.ranges_m[(first + 1) % rays])
    return np.asarray(np.hypot(off[:, 0], off[:, 1]) < free_m - short_m)


class Map:
    """The leader's map of the region: what it has seen so far."""

    def __init__(self, mission: Mission, start: Floats) -> None:
        self._keep_m = mission.obstacle_keep_m
        self._keep_in_m = mission.robot_radius_m + mission.mu0_m
        self._margin_m = mission.range_m_max
        self._bounded = mission.bounds is not None
        self._hits = np.empty((0, 2))
        self._closed = np.empty((0, 2))
        self._closed_for_now = np.empty((0, 2))
        self._made: Cells | None = None
        """Made when they are first asked for (rule 6)."""
        self._lattice: Lattice | None = None
        """Kept for the cells that are made next: often they are those of the same grid."""
        self._newest: CostToGo | None = None
        """The costs of the last plan."""
        self._cell_m = min(CELL_M_MAX, mission.obstacle_keep_m / CELLS_PER_KEEP)
        if mission.bounds is not None:
            bounds = mission.bounds
            low, high = (bounds.x_m_min, bounds.y_m_min), (bounds.x_m_max, bounds.y_m_max)
            self._build(np.array(low), np.array(high))
        else:
            self._build(start - self._margin_m, start + self._margin_m)

    @property
    def hits(self) -> Floats:
        """What has been seen (n, 2) [m; world frame]."""
        return self._hits

    @property
    def cell_m(self) -> float:
        """The size of a cell."""
        return self._grid.cell_m

    @property
    def _cells(self) -> Cells:
        """The cells, with all that is known."""
        if self._made is None:
            cells = Cells(self._grid, keep_in_m=self._keep_in_m if self._bounded else None)
            cells.know(self._hits)
            cells.keep_off(self._hits, self._keep_m)
            cells.keep_off(self._closed, SPOT_KEEPS * self._keep_m)
            cells.keep_off(self._closed_for_now, SPOT_KEEPS * self._keep_m)
            self._made = cells
        return self._made

    def _build(self, low: Floats, high: Floats) -> None:
        """Have the cells made again, over a rectangle."""
        self._grid = Grid.over(low, high, self._cell_m, cells_max=CELLS_MAX)
        self._made = None

    def release(self) -> None:
        """Give up the cells until the map is used again (rule 6)."""
        self._made = self._lattice = self._newest = None

    def extended(self, points: Floats) -> "Map":
        """A copy to which these points (n, 2) have been added."""
        self._lattice = Lattice.of(self._grid)
        other = deepcopy(self)
        other.remember(points)
        return other

    def remember(self, hit_points: Floats) -> None:
        """Add hits (n, 2) [m; world frame]; hits outside the bounds are ignored."""
        if not self._bounded:
            self._reach_out_to(hit_points)
        new = self._cells.know(hit_points[self._grid.has(hit_points)])
        self._hits = np.concatenate([self._hits, new])
        self._cells.keep_off(new, self._keep_m)

    def forget_where_free(self, view: View) -> None:
        """Forget hits where a scan shows free ground (rule 4)."""
        gone = shown_free(self._hits, view, short_m=2.0 * self._grid.cell_m)
        if gone.any():
            self._hits = self._hits[~gone]
            self._build(self._grid.low, self._grid.high)

    def forget(self) -> None:
        """Forget all hits; spots that are closed for good stay closed."""
        self._hits = np.empty((0, 2))
        self._build(self._grid.low, self._grid.high)

    def _reach_out_to(self, points: Floats) -> None:
        """Extend the grid beyond these points by the sensor's range (rule 5)."""
        if len(points) == 0 or self._grid.has(points).all():
            return
        self._build(*self._sides_beyond(points))

    def _sides_beyond(self, points: Floats) -> tuple[Floats, Floats]:
        """The lower left and the upper right corner of a grid that reaches beyond these points (rule 5)."""
        low = np.minimum(self._grid.low, points.min(axis=0) - self._margin_m)
        return low, np.maximum(self._grid.high, points.max(axis=0) + self._margin_m)

    def _is_too_wide(self, points: Floats) -> bool:
        """Whether a grid beyond these points would have cells too large to plan with."""
        wide = Grid.over(*self._sides_beyond(points), self._cell_m, cells_max=CELLS_MAX)
        return wide.cell_m > max(self._keep_m, self._grid.cell_m)

    def close(self, spot: Floats, *, for_good: bool = True) -> None:
        """Close a spot (rule 3)."""
        if for_good:
            self._closed = np.concatenate([self._closed, spot[None]])
        else:
            self._closed_for_now = np.concatenate([self._closed_for_now, spot[None]])
        self._cells.keep_off(spot[None], SPOT_KEEPS * self._keep_m)

    def reopen(self) -> None:
        """Open the spots that were not closed for good."""
        if len(self._closed_for_now):
            self._closed_for_now = np.empty((0, 2))
            self._build(self._grid.low, self._grid.high)

    def cost_to_go(
        self,
        goal: Floats,
        *,
        tolerance_m: float,
        taken: Floats | None = None,
        keep_m: float = 0.0,
        origin: Floats | None = None,
    ) -> CostToGo:
        """Cost from each cell to the goal; if that is closed or cut off, to ground within its tolerance.

        Args:
            goal: (2,) [m; world frame].
            tolerance_m: the distance at which the goal counts as reached.
            taken: a polyline (n, 2) of ground that other robots occupy.
            keep_m: least distance of the robot's centre from that ground.
            origin: where the robot is (2,). Costs above that of the origin may be left infinite.
        """
        if not self._bounded:
            self._reach_out_to(goal[None])
        cells = self._cells
        cell_m, room = self._grid.cell_m, cells.room
        if taken is not None and len(taken) > 1:
            room = room.copy()
            self._grid.lower_along(room, taken, reach_m=keep_m + cell_m, less_m=keep_m)
        near, off_goal_m = self._grid.around(goal, reach_m=max(tolerance_m, cell_m))
        opens = is_open(room.reshape(-1)[near], cell_m)
        there, around = near[opens & (off_goal_m <= cell_m)], near[opens & (off_goal_m <= tolerance_m)]
        sources = there if len(there) else around
        if len(sources) == 0:
            return CostToGo(self._grid, np.full(room.shape, np.inf))
        self._lattice = Lattice.of(self._grid)
        flood = cells.flood
        flood.begin(room, sources)
        if origin is None:
            return self._both_sides(flood, around)
        straight_m = float(np.hypot(*(goal - origin)))
        known_m = straight_m if self._newest is None else float(self._newest.at(origin[None])[0])
        limit_m = max(GROWN * (known_m if known_m < np.inf else straight_m), LEAST_M)
        cost = CostToGo(self._grid, flood.up_to(limit_m).reshape(room.shape))
        while (here_m := cost.at(origin[None])[0]) > flood.reached_m:
            further_m = DETOUR * flood.reached_m
            cost = CostToGo(self._grid, flood.up_to(further_m).reshape(room.shape))
        self._newest = cost
        if here_m <= DETOUR * straight_m or np.isfinite(cost.cells.reshape(-1)[around]).all():
            return cost
        return self._both_sides(flood, around)

    def _both_sides(self, flood: Flood, around: Indices) -> CostToGo:
        """A robot that stands at the goal may split the ground around it; both sides are good enough."""
        cost = flood.up_to(COST_M_MAX)
        cut_off = around[np.isinf(cost[around])]
        if len(cut_off):
            cost = np.minimum(cost, flood.alone(cut_off))
        return CostToGo(self._grid, cost.reshape(self._grid.shape))

    def packed(self) -> bytes:
        """The hits for another robot's map: as many places as fit into a message."""
        places = np.round(self._hits / PACKED_M).astype("<i4")
        while len(packed := zlib.compress(places.T.tobytes())) > SEEN_BYTES_MAX:
            places = places[::2]
        return packed

    def unpack(self, packed: bytes) -> None:
        """Add the hits of another robot's map (rule 5); invalid data is ignored."""
        unpacking = zlib.decompressobj()
        try:
            raw = unpacking.decompress(packed, PLACES_MAX * 8)
        except zlib.error:
            return
        if len(raw) % 8 != 0 or not raw:
            return
        hits = np.frombuffer(raw, "<i4").reshape(2, -1).T * PACKED_M
        self.remember(hits[self._grid.has(hits)] if self._is_too_wide(hits) else hits)

    def narrowest(self, way: Floats) -> Floats:
        """The point (2,) of a way (n, 2) with the least room."""
        cells = self._grid.cells_of(way)
        return np.asarray(way[int(np.argmin(self._cells.room[cells[:, 0], cells[:, 1]]))])
