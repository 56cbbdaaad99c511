"""The outlines of blocked cells as polygons that a scenario takes.

Rule 1: the polygons cover exactly the blocked cells: no cell is cut into, and no other ground is covered.
Rule 2: each polygon is simple and has no hole; ground with holes is cut along lines between cells. Cells that
        touch at a corner only may become two polygons, which touch there.
"""

import numpy as np
import shapely
from scipy import ndimage

from protocol.arrays import Flags, Floats

CORNERS_MAX = 200  # of a polygon; a scenario takes 2000, but its checks take quadratic time


def coarsened(blocked: Flags, by: int) -> Flags:
    """Blocks of `by` x `by` cells as one cell each, blocked if any cell is; blocked beyond the rim."""
    rows, columns = blocked.shape
    padded = np.pad(blocked, ((0, -rows % by), (0, -columns % by)), constant_values=True)
    blocks = padded.reshape(padded.shape[0] // by, by, padded.shape[1] // by, by)
    return np.asarray(blocks.any(axis=(1, 3)))


def pieces_min(blocked: Flags) -> int:
    """At least so many polygons cover the blocked cells."""
    return int(ndimage.label(blocked)[1])


def outlines(blocked: Flags) -> list[Floats]:
    """The corners (n, 2) of each polygon: x, y, in cells from the lower left corner."""
    steps = np.diff(np.pad(blocked, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    row, first = np.nonzero(steps == 1)
    last = np.nonzero(steps == -1)[1]
    union = shapely.union_all(shapely.box(first, row, last, row + 1))
    waiting, done = _polygons(union), []
    while waiting:
        polygon = waiting.pop()
        ring = shapely.get_coordinates(shapely.simplify(polygon.exterior, 0.0))[:-1]
        if polygon.interiors or len(ring) > CORNERS_MAX:
            waiting.extend(_halves(polygon))
        else:
            done.append(np.rint(ring))
    return done


def _halves(polygon: shapely.Polygon) -> list[shapely.Polygon]:
    """The polygon, cut where a hole begins (the middle one), or else in the middle."""
    low_x, low_y, high_x, high_y = polygon.bounds
    axis = int(high_y - low_y > high_x - low_x)
    holes = sorted(ring.bounds[axis] for ring in polygon.interiors)
    at = holes[len(holes) // 2] if holes else (polygon.bounds[axis] + polygon.bounds[axis + 2]) // 2
    if axis == 0:
        sides = shapely.box(low_x, low_y, at, high_y), shapely.box(at, low_y, high_x, high_y)
    else:
        sides = shapely.box(low_x, low_y, high_x, at), shapely.box(low_x, at, high_x, high_y)
    return [part for side in sides for part in _polygons(polygon & side)]


def _polygons(geometry: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons in a geometry; a cut may leave points and lines, too."""
    return [part for part in shapely.get_parts(geometry) if isinstance(part, shapely.Polygon)]
