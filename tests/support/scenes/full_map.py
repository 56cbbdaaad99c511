"""Decides on the full map whether a disc can move from a scene's start to its goal. Not a test file.

Only shapely decides. Obstacles grow by the distance that the disc's centre keeps from them; start and goal
must lie in the same piece of the remaining ground. Shapely approximates arcs by chords, so it is asked twice.
With obstacles slightly too large, a way that it finds certainly exists. With obstacles slightly too small, a
way that it does not find certainly does not exist.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import shapely

QUARTER_CHORDS = 32  # error of an arc of radius 1 m: at most 1 - cos(pi / 4 / 32) = 0.3 mm
ARC_SHARE = math.cos(math.pi / 4.0 / QUARTER_CHORDS)  # distance of a chord's middle, as a share of the radius
ROUNDING_M = 1e-7  # ten times the largest error of shapely's overlays seen on scenes of this size


class Answer(StrEnum):
    """The answer of the full map."""

    SOLVABLE = "surely solvable"
    UNSOLVABLE = "surely not solvable"
    BETWEEN = "within shapely's error of both"


@dataclass(frozen=True)
class Disc:
    """The disc that moves."""

    radius_m: float
    """The radius of its hull, which stays inside the bounds."""
    clearance_m: float = 0.0
    """The clearance between hull and obstacles."""

    @property
    def keep_m(self) -> float:
        """The distance between its centre and obstacles."""
        return self.radius_m + self.clearance_m


def solvable(scene: dict[str, Any], disc: Disc) -> Answer:
    """Whether the disc gets from the start of a `clew-scene/1` to within its goal's tolerance."""
    if _has_way(scene, disc, grow=1.0 / ARC_SHARE, rounding_m=ROUNDING_M):
        return Answer.SOLVABLE
    if _has_way(scene, disc, grow=1.0, rounding_m=-ROUNDING_M):
        return Answer.BETWEEN
    return Answer.UNSOLVABLE


def obstacles(scene: dict[str, Any], *, grown_m: float, grow: float) -> Iterator[shapely.Geometry]:
    """Every obstacle, grown; the radius of all arcs times `grow`."""
    for x, y, radius_m in scene["circles"]:
        yield shapely.Point(x, y).buffer(grow * (radius_m + grown_m), quad_segs=QUARTER_CHORDS)
    for ring in (*scene["polygons"], *scene["walls"]):
        yield shapely.Polygon(ring).buffer(grow * grown_m, quad_segs=QUARTER_CHORDS)


def _has_way(scene: dict[str, Any], disc: Disc, *, grow: float, rounding_m: float) -> bool:
    room = shapely.box(*scene["bounds"]).buffer(-disc.radius_m - rounding_m, join_style="mitre")
    closed = shapely.union_all(list(obstacles(scene, grown_m=disc.keep_m + rounding_m, grow=grow)))
    start = shapely.Point(scene["start"][:2])
    # The goal errs the other way: it is slightly too small if obstacles are too large.
    goal_tolerance_m = scene["goal_tol"] / (ARC_SHARE * grow) - rounding_m
    goal = shapely.Point(scene["goal"]).buffer(goal_tolerance_m, quad_segs=QUARTER_CHORDS)
    return any(
        piece.covers(start) and piece.intersects(goal) for piece in shapely.get_parts(room.difference(closed))
    )
