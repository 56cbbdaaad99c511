"""What a robot takes along from view to view: the places that it has not left, and counts.

Rule 1 (safety): a driven leg is told as it was laid, and not as from where bodies stand beside it. Else their
        drives' errors would add up, from view to view.
Rule 2 (safety): no leg counts as driven where one of both robots stands further beside its place than one
        drive may be off: another process may have moved its body while this one was stopped, and nobody has
        driven from there. The tolerance counts on that (`agents.coordinating.formation`, rule 3).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from agents.strand.member import Member
from protocol.arrays import nearest_on_segments, xy
from protocol.fence import Epoch
from protocol.frames import Point, Pose, Vertex, apart_m
from protocol.path import ON_LINE_M, THERE_M, Path
from protocol.wire.view import FORMERS_MAX, LEG_CORNERS_MAX, Counters, Former

COASTS_M = 1.0  # a body stands at once when the fence rises: only what odometry had not told yet


@dataclass(frozen=True, slots=True)
class OldPlace:
    """A robot's place on the path of a formation that has ended."""

    epoch: Epoch
    rank: int
    progress_m: float
    path: Path
    """As far as the robot knew it."""
    behind_m: float | None = None
    """Where the robot behind was last heard; none: there was none."""

    def former(self, pose: Pose) -> Former:
        """Where it stands now, on the same path a little further on."""
        until_m = min(self.progress_m + COASTS_M, self.path.end_m)
        corners = self.path.between(self.progress_m, until_m)
        lengths_m = np.hypot(*np.diff(corners, axis=0).T)
        place = xy(pose)
        nearest = nearest_on_segments(place, corners[:-1], corners[1:])
        segment = int(np.argmin(np.hypot(*(nearest - place).T)))
        along_m = float(lengths_m[:segment].sum() + np.hypot(*(nearest[segment] - corners[segment])))
        s_m = min(self.progress_m + along_m, self.path.end_m)
        leg = self._leg(s_m)
        from_m = None if leg is None else self.behind_m
        at = self.path.at(s_m)
        return Former(epoch=self.epoch, rank=self.rank, s_m=s_m, at=at, leg_from_m=from_m, corners=leg or ())

    def _leg(self, to_m: float) -> tuple[Vertex, ...] | None:
        """Corners of the path from the robot behind on; None if there are too many, or is no such robot."""
        if self.behind_m is None:
            return None
        first = self.path.next_vertex(self.behind_m)
        inner = self.path.told_from(first, self.path.next_vertex(to_m - THERE_M) - first)
        return inner if len(inner) <= LEG_CORNERS_MAX else None


@dataclass(frozen=True, slots=True)
class Past:
    """A robot's places, and what the fleet had counted in the last strand that it was in."""

    places: tuple[OldPlace, ...] = ()
    """On the paths of formations, newest first."""
    draft: Former | None = None
    """Its place in a draft of which no formation was made."""
    counters: Counters = field(default_factory=Counters)
    counted: Epoch = field(default_factory=Epoch)
    """The formation that the counters are from."""
    arrived: bool = False
    """Whether the robot stood at its place at the goal."""
    neighbours: Mapping[int, Point] = field(default_factory=dict)
    """Where its neighbours were when it last heard them."""

    def with_strand(self, member: Member) -> Self:
        """After a strand: older places count only for a robot that has not moved in it.

        A robot that did not stand at its place in it has no place at all.
        """
        formation, strand = member.formation, member.strand
        place = OldPlace(formation.epoch, formation.rank, member.progress_m, member.path, strand.behind_m)
        older = () if member.has_moved else self.places
        places = (place, *older)[: FORMERS_MAX - 1] if member.fits else ()
        neighbours = {**self.neighbours, **strand.neighbours}
        return type(self)(places, None, member.counters, formation.epoch, member.arrived, neighbours)

    def with_draft(self, epoch: Epoch, rank: int | None) -> Self:
        """The coordinator has told this robot's place in its draft, or that it has none."""
        if rank is not None:
            return replace(self, draft=Former(epoch=epoch, rank=rank))
        ends = self.draft is not None and self.draft.epoch == epoch
        return replace(self, draft=None) if ends else self

    def elsewhere(self) -> Self:
        """The robot has driven by its own steps: it stands at none of its places."""
        return replace(self, places=(), draft=None)

    def formers(self, pose: Pose) -> tuple[Former, ...]:
        """What a report tells, newest first."""
        draft = () if self.draft is None else (self.draft,)
        return (*draft, *(place.former(pose) for place in self.places))

    def leg_to(
        self, ahead: tuple[Former, ...], pose: Pose, ahead_at: Pose, *, off_m_max: float
    ) -> tuple[Point, ...] | None:
        """The driven way to the robot ahead, which tells its corners; None if no path of one epoch is one.

        The robot ahead knows all of the path that it has driven; this one may have been cut off before. A
        robot that stands further off its place than `off_m_max` has left it (rule 2).
        """
        for own in (place.former(pose) for place in self.places):
            theirs = next((each for each in ahead if each.epoch == own.epoch and not each.draft), None)
            if theirs is None or theirs.leg_from_m is None or theirs.rank + 1 != own.rank:
                continue
            if theirs.leg_from_m <= own.s_m <= theirs.s_m:
                inner = (vertex for vertex in theirs.corners if vertex.s_m > own.s_m + THERE_M)
                corners = (Point(x_m=vertex.x_m, y_m=vertex.y_m) for vertex in inner)
                start, end = _on_path(own, pose, off_m_max), _on_path(theirs, ahead_at, off_m_max)
                if start is not None and end is not None:
                    return (start, *corners, end)
        return None


def _on_path(former: Former, pose: Pose, off_m_max: float) -> Point | None:
    """Rule 1: where a leg begins or ends; None if the robot stands elsewhere."""
    at = former.at
    off_m = math.inf if at is None else apart_m(pose, at)
    if off_m > off_m_max:
        return None
    return at if off_m > ON_LINE_M else Point(x_m=pose.x_m, y_m=pose.y_m)
