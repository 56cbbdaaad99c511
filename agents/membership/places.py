"""The places that a robot had in formations and drafts, and has not left since."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from protocol.arrays import nearest_on_segments, xy
from protocol.fence import Epoch
from protocol.frames import Point, Pose
from protocol.path import THERE_M, Path
from protocol.wire.view import FORMERS_MAX, LEG_CORNERS_MAX, Former

COASTS_M = 1.0  # a body stands at once when the fence rises: only what odometry had not told yet


@dataclass(frozen=True, slots=True)
class Berth:
    """A robot's place on the path of a formation that has ended."""

    epoch: Epoch
    rank: int
    progress_m: float
    path: Path
    """As far as the robot knew it."""

    def former(self, pose: Pose) -> Former:
        """Where it stands now, on the same path a little further on."""
        until_m = min(self.progress_m + COASTS_M, self.path.end_m)
        corners = self.path.between(self.progress_m, until_m)
        lengths_m = np.hypot(*np.diff(corners, axis=0).T)
        place = xy(pose)
        nearest = nearest_on_segments(place, corners[:-1], corners[1:])
        segment = int(np.argmin(np.hypot(*(nearest - place).T)))
        along_m = float(lengths_m[:segment].sum() + np.hypot(*(nearest[segment] - corners[segment])))
        return Former(epoch=self.epoch, rank=self.rank, s_m=min(self.progress_m + along_m, self.path.end_m))

    def leg(self, from_m: float, to_m: float) -> tuple[Point, ...] | None:
        """Corners of the path between two arc lengths; None if this robot does not know it all."""
        if to_m > self.path.end_m + THERE_M:
            return None
        inner = [
            Point(x_m=vertex.x_m, y_m=vertex.y_m)
            for vertex in self.path
            if from_m + THERE_M < vertex.s_m < to_m - THERE_M
        ]
        return tuple(inner) if len(inner) <= LEG_CORNERS_MAX else None


@dataclass(frozen=True, slots=True)
class Places:
    """All of them; a robot that drives by its own steps leaves them all."""

    berths: tuple[Berth, ...] = ()
    draft: Former | None = None

    def with_berth(self, berth: Berth, *, moved: bool) -> Self:
        """The strand has ended: older places count only for a robot that has not moved in it."""
        older = () if moved else self.berths
        return type(self)((berth, *older)[: FORMERS_MAX - 1])

    def with_draft(self, epoch: Epoch, rank: int | None) -> Self:
        """The coordinator has told this robot's place in its draft, or that it has none."""
        draft = self.draft
        if rank is not None:
            draft = Former(epoch=epoch, rank=rank, draft=True)
        elif draft is not None and draft.epoch == epoch:
            draft = None
        return type(self)(self.berths, draft)

    def formers(self, pose: Pose) -> tuple[Former, ...]:
        """What a report tells, newest first."""
        draft = () if self.draft is None else (self.draft,)
        return (*draft, *(berth.former(pose) for berth in self.berths))

    def leg_to(self, ahead: tuple[Former, ...], pose: Pose) -> tuple[Point, ...] | None:
        """Corners of a driven way to the robot ahead; None if no path of one epoch leads to it."""
        for berth in self.berths:
            own = berth.former(pose)
            theirs = next((each for each in ahead if each.epoch == berth.epoch and not each.draft), None)
            if theirs is not None and theirs.rank + 1 == own.rank and own.s_m <= theirs.s_m:
                corners = berth.leg(own.s_m, theirs.s_m)
                if corners is not None:
                    return corners
        return None
