"""How the strand's path grows by the leader's switching steps.

Rule 1: where nothing moves it grows by a whole step at once.
Rule 2: where obstacles move the leader may have to stop short of a step's end. So there the path only
        grows by what has been driven, and ends where the step does.
"""

import math

from protocol.frames import Point
from protocol.mission import Mission
from protocol.path import Path


class Growth:
    """The end of the path, as far as the robot that leads takes it."""

    def __init__(self, path: Path, mission: Mission) -> None:
        self._path = path
        self._mission = mission
        self.pending: Point | None = None
        """Where the step under way is to end, while it may still stop short of it."""
        self._step_from = Point(x_m=0.0, y_m=0.0)

    def begin(self, target: Point) -> None:
        """The leader begins a step."""
        if self._mission.obstacles_move:
            self.pending = target
            self._step_from = self._path.at(self._path.end_m)
        else:
            self._path.extend(target)

    def come_to(self, progress_m: float) -> None:
        """The leader has come so far on its step, straight towards its end."""
        path = self._path
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
        """The leader's step has ended where it has come to."""
        self.pending = None

    @property
    def planned(self) -> Path:
        """The path, with what is planned of it."""
        if self.pending is None:
            return self._path
        return Path([*(Point(x_m=each.x_m, y_m=each.y_m) for each in self._path), self.pending])
