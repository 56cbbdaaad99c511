"""Ground with one corridor after another: a zig-zag, and a comb of dead ends."""

import math

import numpy as np
from numpy.random import Generator

from clew.fields.built import Built, Corner, cells_of, rectangle, rounded
from protocol.arrays import Floats

SLOPES_RAD = (math.radians(40.0), math.radians(72.0))  # the teeth between two legs have 36 to 100 degrees
LEGS_MIN = (3, 5)  # where the ground is not high enough for legs so long, there are more
SHORTER = 0.3  # by at most so much of its height a leg ends early
DEPTHS = (0.4, 0.9)  # of a dead end, as a share of the ground


def zigzag(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """One corridor whose legs rise and fall with the same slope; the ground ends where a leg ends."""
    slope_rad = chance.uniform(*SLOPES_RAD)
    edge_m = width_m / 2.0 / math.cos(slope_rad) + wall_m  # so thick is the wall beside the outermost corner
    legs = int(chance.integers(LEGS_MIN[0], LEGS_MIN[1] + 1))
    run_m = size_m[0] - 2.0 * width_m
    high_m = size_m[1] - 2.0 * edge_m
    climb_m = min(math.tan(slope_rad) * run_m / legs, high_m)
    low_m = edge_m + chance.uniform() * (high_m - climb_m)
    y_m = float(chance.uniform(low_m, low_m + climb_m))
    line = [(0.0, y_m), (width_m, y_m)]  # straight in: no sharp corner at the mouth
    rises = y_m < low_m + climb_m / 2.0
    while True:
        into_m = chance.uniform(0.0, SHORTER) * climb_m
        y_m = low_m + climb_m - into_m if rises else low_m + into_m
        x_m = line[-1][0] + abs(y_m - line[-1][1]) / math.tan(slope_rad)
        if x_m > size_m[0] - width_m:
            break
        line.append((x_m, y_m))
        rises = not rises
    line.append((line[-1][0] + width_m, line[-1][1]))
    length_m, height_m = line[-1][0], size_m[1]
    above, below = (_beside(line, side * width_m / 2.0) for side in (1.0, -1.0))
    return Built(
        size_m=(length_m, height_m),
        walls=[
            rounded([*above, (length_m, height_m), (0.0, height_m)]),
            rounded([*below, (length_m, 0.0), (0.0, 0.0)]),
        ],
        entrance_y_m=line[0][1],
        exit_y_m=line[-1][1],
    )


def comb(chance: Generator, *, size_m: tuple[float, float], width_m: float, wall_m: float) -> Built:
    """Corridors side by side towards the goal; all but one are dead ends."""
    rows, pitch_m = cells_of(size_m, width_m, wall_m)[1], width_m + wall_m
    length_m = size_m[0]
    walls = [
        rectangle(0.0, length_m, row * pitch_m + width_m, (row + 1) * pitch_m) for row in range(rows - 1)
    ]
    way_through, entrance = int(chance.integers(rows)), int(chance.integers(rows))
    for row in range(rows):
        if row != way_through:
            depth_m = chance.uniform(*DEPTHS) * length_m
            low_m = row * pitch_m - wall_m / 2.0  # into the walls: rays must not get between them
            walls.append(rectangle(depth_m, depth_m + wall_m, low_m, low_m + pitch_m))
    return Built(
        size_m=(length_m, rows * pitch_m - wall_m),
        walls=walls,
        entrance_y_m=entrance * pitch_m + width_m / 2.0,
        exit_y_m=way_through * pitch_m + width_m / 2.0,
    )


def _beside(line: list[Corner], off_m: float) -> Floats:
    """The line moved to its left by so much, with its corners kept."""
    corners = np.array(line)
    legs = np.diff(corners, axis=0)
    normals = np.stack([-legs[:, 1], legs[:, 0]], axis=1) / np.hypot(*legs.T)[:, None]
    before, after = np.vstack([normals[:1], normals]), np.vstack([normals, normals[-1:]])
    return np.asarray(corners + off_m * (before + after) / (1.0 + (before * after).sum(axis=1))[:, None])
