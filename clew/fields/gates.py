"""Ground with many gates of one width: rooms with doors, and a forest of pillars."""

import math

from numpy.random import Generator

from clew.fields.built import Built, cells_of, rectangle
from clew.fields.maze import tree
from clew.fields.shapes import DECIMALS

ROOM_WIDTHS = 2.5  # side of a room in widths of its doors
DOORS_MORE = 0.25  # share of the walls that have a door though no way needs it
PILLAR_WALLS = (0.5, 1.5)  # radius of a pillar in thicknesses of a wall
JITTER_WALLS = 1.5  # how far a pillar may stand off its row
FIRST_GAPS = (0.1, 0.9)  # of the gap between a wall and the first pillar, in widths: nobody fits


def rooms(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """Rooms on a grid; a door in each wall that is needed to reach all rooms, and in some others."""
    side_m = ROOM_WIDTHS * width_m
    pitch_m = side_m + wall_m
    columns, rows = cells_of(size_m, side_m, wall_m)
    entrance, way_out = int(chance.integers(rows)), int(chance.integers(rows))
    open_walls = {frozenset(pair) for pair in tree((0, entrance), columns, rows, chance).items()}
    open_walls |= {frozenset({(-1, entrance), (0, entrance)})}
    open_walls |= {frozenset({(columns - 1, way_out), (columns, way_out)})}
    size = (columns * pitch_m + wall_m, rows * pitch_m - wall_m)
    walls = []

    def pieces(*, has_door: bool) -> list[tuple[float, float]]:
        """The parts of a wall beside a room, from corner to corner; each includes its joint."""
        first_m = float(chance.uniform(0.0, side_m - width_m))
        if not has_door:
            return [(-wall_m, side_m + wall_m)]
        return [(-wall_m, first_m), (first_m + width_m, side_m + wall_m)]

    doors_y_m = {}
    for line in range(columns + 1):
        for row in range(rows):
            wanted = frozenset({(line - 1, row), (line, row)}) in open_walls
            more = 0 < line < columns and chance.random() < DOORS_MORE
            parts = pieces(has_door=wanted or more)
            doors_y_m[line, row] = row * pitch_m + parts[0][1] + width_m / 2.0
            walls += [
                rectangle(
                    line * pitch_m,
                    line * pitch_m + wall_m,
                    max(row * pitch_m + low_m, 0.0),
                    min(row * pitch_m + high_m, size[1]),
                )
                for low_m, high_m in parts
            ]
    for column in range(columns):
        for line in range(1, rows):
            wanted = frozenset({(column, line - 1), (column, line)}) in open_walls
            left_m, low_m = column * pitch_m + wall_m, line * pitch_m - wall_m
            walls += [
                rectangle(left_m + from_m, left_m + to_m, low_m, low_m + wall_m)
                for from_m, to_m in pieces(has_door=wanted or chance.random() < DOORS_MORE)
            ]
    return Built(
        size_m=size,
        walls=walls,
        entrance_y_m=doors_y_m[0, entrance],
        exit_y_m=doors_y_m[columns, way_out],
    )


def pillars(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """Rows of pillars across the ground, all gaps of a row as wide as asked; rows are that far apart."""
    half_row_m = (PILLAR_WALLS[1] + JITTER_WALLS) * wall_m
    pitch_m = 2.0 * half_row_m + width_m
    rows = max(int((size_m[0] + width_m) / pitch_m), 1)
    stand = []
    for row in range(rows):
        x_m, y_m, radius_m = math.nan, 0.0, 0.0
        while y_m + radius_m < size_m[1]:
            off_m = row * pitch_m + half_row_m + float(chance.uniform(-1.0, 1.0)) * JITTER_WALLS * wall_m
            new_m = float(chance.uniform(*PILLAR_WALLS)) * wall_m
            if radius_m == 0.0:  # the first of its row
                y_m = width_m * float(chance.uniform(*FIRST_GAPS)) + new_m
            else:
                apart_m = radius_m + width_m + new_m
                y_m += math.sqrt(apart_m**2 - (off_m - x_m) ** 2)
            x_m, radius_m = off_m, new_m
            if y_m - radius_m < size_m[1]:
                stand.append((round(x_m, DECIMALS), round(y_m, DECIMALS), round(radius_m, DECIMALS)))
    return Built(
        size_m=(rows * pitch_m - width_m, size_m[1]),
        pillars=stand,
        entrance_y_m=size_m[1] / 2.0,
        exit_y_m=size_m[1] / 2.0,
    )
