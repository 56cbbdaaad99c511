"""Corridors: a maze on a grid, all of one width, with dead ends and exactly one way through.

Cells are (column, row), from the lower left. Grid lines are as thick as the walls. Cell (0, 0) begins at
x = one wall and y = 0; the scene must have another wall below y = 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from clew.fields.built import Built, Ring, rectangle
from protocol.arrays import Flags

Cell = tuple[int, int]


@dataclass(frozen=True, slots=True)
class _Grid:
    """Which walls exist: `upright` at (line, row) left of a column, `level` at (column, line) below a row."""

    upright: Flags
    level: Flags

    @staticmethod
    def closed(columns: int, rows: int) -> "_Grid":
        """All walls, except those along the two long sides, which the scene adds."""
        level = np.ones((columns, rows + 1), dtype=np.bool_)
        level[:, [0, -1]] = False
        return _Grid(np.ones((columns + 1, rows), dtype=np.bool_), level)

    def set_wall(self, one: Cell, other: Cell, *, stands: bool) -> None:
        """Build or remove the wall between two neighbouring cells."""
        if one[1] == other[1]:
            self.upright[max(one[0], other[0]), one[1]] = stands
        else:
            self.level[one[0], max(one[1], other[1])] = stands


def maze(
    columns: int, rows: int, chance: Generator, *, width_m: float, wall_m: float, plugged: bool
) -> Built:
    """A maze that is entered on the left and left on the right.

    Args:
        columns: cells from left to right.
        rows: cells from bottom to top.
        chance: the source of all draws.
        width_m: width of the corridors.
        wall_m: thickness of the walls.
        plugged: whether one passage of the way through is closed.
    """
    entrance, way_out = (0, int(chance.integers(rows))), (columns - 1, int(chance.integers(rows)))
    grid = _Grid.closed(columns, rows)
    came_from = tree(entrance, columns, rows, chance)
    for cell, before in came_from.items():
        grid.set_wall(cell, before, stands=False)
    grid.set_wall((-1, entrance[1]), entrance, stands=False)
    grid.set_wall(way_out, (columns, way_out[1]), stands=False)
    if plugged:
        way = _way(way_out, came_from)
        plug = way[int(chance.integers(len(way)))]
        grid.set_wall(plug, came_from[plug], stands=True)
    pitch_m = width_m + wall_m
    return Built(
        size_m=(columns * pitch_m + wall_m, rows * pitch_m - wall_m),
        walls=_walls(grid, width_m, wall_m),
        entrance_y_m=entrance[1] * pitch_m + width_m / 2.0,
        exit_y_m=way_out[1] * pitch_m + width_m / 2.0,
    )


def tree(root: Cell, columns: int, rows: int, chance: Generator) -> dict[Cell, Cell]:
    """The previous cell of each cell but the root, by a depth-first walk, which makes long dead ends."""
    came_from: dict[Cell, Cell] = {}
    stack = [root]
    while stack:
        column, row = stack[-1]
        around = [(column + 1, row), (column - 1, row), (column, row + 1), (column, row - 1)]
        fresh = [
            cell
            for cell in around
            if 0 <= cell[0] < columns and 0 <= cell[1] < rows and cell != root and cell not in came_from
        ]
        if not fresh:
            stack.pop()
            continue
        entered = fresh[int(chance.integers(len(fresh)))]
        came_from[entered] = (column, row)
        stack.append(entered)
    return came_from


def _way(end: Cell, came_from: dict[Cell, Cell]) -> list[Cell]:
    """The cells from the end back to the root, without the root."""
    way = []
    while end in came_from:
        way.append(end)
        end = came_from[end]
    return way


def _walls(grid: _Grid, width_m: float, wall_m: float) -> list[Ring]:
    """Each straight run of walls as one rectangle, including the joints at both ends."""
    pitch_m = width_m + wall_m
    height_m = grid.upright.shape[1] * pitch_m - wall_m
    walls = [
        rectangle(
            line * pitch_m,
            line * pitch_m + wall_m,
            max(first * pitch_m - wall_m, 0.0),
            min(end * pitch_m, height_m),
        )
        for line, column in enumerate(grid.upright)
        for first, end in _runs(column)
    ]
    walls += [
        rectangle(first * pitch_m, end * pitch_m + wall_m, line * pitch_m - wall_m, line * pitch_m)
        for line, row in enumerate(grid.level.T)
        for first, end in _runs(row)
    ]
    return walls


def _runs(stands: Flags) -> list[tuple[int, int]]:
    """The first index of each run of walls, and the index after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stands, [False]]).astype(int)))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]
