"""Making a formation. Pure.

Rule 1: it is made once; its pieces are sent again byte for byte (F4).
Rule 2: every member is told the whole path from the tail on, with arc lengths. Of places and lives it is told
        only its own and those of its two neighbours.
Rule 3 (safety): its path leads from place to place, tail first. A leg that has been driven is laid where it
        was, and so are the places at its ends: bodies may stand beside them by what their drives were off. A
        path through where they stand would be off by that much more in every view.

Why rule 3 keeps S1 over any number of views: let e be what one drive may be off, a quarter of mu0 at most. A
leg is one of two. A leader's step, or a leg that was seen when it was new, kept epsilon, less mu0 / 2, from
where a body stood to where it led, both ends included: a tail may come back to where its leg began
(`agents/navigation/leg.py`). It is laid between places of the path, so it is off that by e at most.
Or the leg was driven: then it has the same vertices as before, and nothing is added. A body is off the path
by e at most, since each of its orders ends on the path. So it keeps epsilon less mu0 / 2 + 2 e. To where
the first robot began the next one comes only if that keeps epsilon less 3/4 of mu0 (`leg.py`, rule 4); it is
e off that. Else the strand does not turn round there, either (`agents/strand/leading.py`, rule 5).

Rule 4 (safety): the path keeps the radius and e from the bounds, which no scan shows. Else new legs through
        where bodies stand, each e nearer to the bounds than the last, would lead them out over some views.
        A start is off it by e at most; in a corner by what 2 e leaves (`world/scenario/checks.py`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from agents.coordinating.folding import Legs
from protocol.arrays import places_xy
from protocol.frames import Point, Pose
from protocol.mission import Bounds
from protocol.path import Path, straightened
from protocol.timeline import StrandFormed
from protocol.wire.view import PIECE_VERTICES_MAX, Formation

Laid = tuple[Path, Mapping[int, float]]
"""A path, and each robot's arc length along it."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What a view has agreed on."""

    members: Mapping[int, Formation]
    """What each member is told, leader first; not cut into pieces yet."""
    sensed: bool

    @property
    def order(self) -> tuple[int, ...]:
        """The members, leader first."""
        return tuple(self.members)

    def pieces(self, robot: int) -> tuple[Formation, ...]:
        """Rule 2: what one member is told."""
        whole = self.members[robot]
        return tuple(
            replace(
                whole,
                seen=None if first else whole.seen,
                first=first,
                path=whole.path[first : first + PIECE_VERTICES_MAX],
            )
            for first in range(0, whole.vertices, PIECE_VERTICES_MAX)
        )

    def as_record(self) -> StrandFormed:
        """What the timeline tells of it."""
        members = tuple(self.members.values())
        return StrandFormed(
            epoch=members[0].epoch.number,
            turn=members[0].turn,
            order=self.order,
            lives=tuple(f"{member.life:x}" for member in members),
            places_m=tuple(member.s_m for member in members),
            laid=tuple(Point(x_m=vertex.x_m, y_m=vertex.y_m) for vertex in members[0].path),
            driven=tuple(member.leg_is_driven for member in members),
            back_by_m=members[0].back_by_m,
            sensed=self.sensed,
        )


def lay_path(
    order: Sequence[int], places: Mapping[int, Pose], legs: Legs, within: Bounds | None = None
) -> Laid:
    """Rules 3 and 4."""
    points: list[Point] = []
    at: dict[int, int] = {}
    is_laid = False  # whether a driven leg has led to the robot's place
    for robot in reversed(order):
        leg = legs.get(robot, ()) if robot != order[0] else ()
        if leg or not is_laid:
            here = leg[0] if leg else _inside(within, places[robot])
            points += [here] if points[-1:] != [here] else []
        at[robot] = len(points) - 1
        points += leg[1:]
        is_laid = bool(leg)
    steps_m = np.hypot(*np.diff(places_xy(points), axis=0).T)
    arcs_m = np.concatenate([[0.0], np.cumsum(steps_m)])
    # A straight queue is one segment: one check, no stops.
    path = Path(straightened(points))
    end_m = path.end_m
    return path, {robot: min(float(arcs_m[index]), end_m) for robot, index in at.items()}


def _inside(bounds: Bounds | None, place: Pose) -> Point:
    """The nearest point in these bounds; without bounds, the place itself."""
    return Point(x_m=place.x_m, y_m=place.y_m) if bounds is None else bounds.nearest(place)
