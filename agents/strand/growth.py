"""How the strand's path grows by the leader's switching steps.

Rule 1: where no obstacle moves, the path grows by a whole step at once.
Rule 2: where obstacles move, the leader may have to stop short of a step's end. So the path grows only by
        what has been driven, and ends where the step ends.
Rule 3: guidance shows a way on from a step's end. It is no part of the path: it only holds grants back
        (`agents.strand.grants`).
"""

import math
from collections.abc import Sequence

from protocol.frames import Point
from protocol.mission import Mission
from protocol.path import Path
from protocol.sweep import Place


class Growth:
    """The growth of the path by the leader's steps."""

    def __init__(self, path: Path, mission: Mission) -> None:
        self._path = path
        self._mission = mission
        self.pending: Point | None = None
        """The end of the current step, while the leader may still stop short of it."""
        self.onward: Sequence[Place] = ()
        """The way that the leader is likely to go on (rule 3)."""
        self._step_from = Point(x_m=0.0, y_m=0.0)

    def begin(self, target: Point, onward: Sequence[Place]) -> None:
        """Begin a step of the leader."""
        self.onward = onward
        if self._mission.obstacles_move:
            self.pending = target
            self._step_from = self._path.at(self._path.end_m)
        else:
            self._path.extend(target)

    def come_to(self, progress_m: float) -> None:
        """Extend the path to the leader's progress on its straight step."""
        self._stretch(self._path, progress_m)

    def driven(self, progress_m: float) -> Path:
        """The path up to there, if the leader is on its way; else the path. It changes nothing."""
        path = self._path.copy() if self.pending is not None else self._path
        self._stretch(path, progress_m)
        return path

    def _stretch(self, path: Path, progress_m: float) -> None:
        if self.pending is None or progress_m <= path.end_m:
            return
        begun = path.at(path.end_m) != self._step_from
        way = Path([self._step_from, self.pending])
        driven_m = progress_m - path.end_m
        if begun:
            done = path.at(path.end_m)
            driven_m += math.hypot(done.x_m - self._step_from.x_m, done.y_m - self._step_from.y_m)
        (path.stretch if begun else path.extend)(way.at(driven_m))

    def end(self) -> None:
        """End the step where the leader is."""
        self.pending = None

    @property
    def planned(self) -> Path:
        """The path, including the rest of the current step."""
        if self.pending is None:
            return self._path
        return Path([*(Point(x_m=each.x_m, y_m=each.y_m) for each in self._path), self.pending])
