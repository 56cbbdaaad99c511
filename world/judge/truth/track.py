"""Where a body was lately, by its sampled poses: between two samples it moved straight at constant speed."""

from bisect import bisect_right
from collections import deque
from itertools import islice

from protocol.frames import Point
from protocol.timeline import PoseSampled
from world.judge.rules.evidence import apart_m

Sampled = tuple[float, PoseSampled]


class Track:
    """The samples of one body, in order of time."""

    def __init__(self) -> None:
        self._samples: deque[Sampled] = deque()

    def hear(self, t_s: float, pose: PoseSampled) -> None:
        """The body was here then. Of a body that stands, two samples say all."""
        samples = self._samples
        if len(samples) > 1 and all(apart_m(pose, each) == 0.0 for _, each in islice(reversed(samples), 2)):
            samples.pop()
        samples.append((t_s, pose))

    def forget(self, before_s: float) -> None:
        """Nothing will be asked about earlier times."""
        while len(self._samples) > 1 and self._samples[1][0] <= before_s:
            self._samples.popleft()

    def at(self, t_s: float) -> Point | None:
        """Where the body was; None if it was never sampled."""
        if not self._samples:
            return None
        after = bisect_right(self._samples, t_s, key=lambda each: each[0])
        (start_s, start), (end_s, end) = (
            self._samples[max(after - 1, 0)],
            self._samples[min(after, len(self._samples) - 1)],
        )
        share = (t_s - start_s) / (end_s - start_s) if start_s < t_s < end_s else 0.0
        return Point(
            x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m)
        )

    def off_m(self, place: Point, from_s: float, until_s: float) -> float:
        """How far the body came from a place in that time."""
        return max(
            (apart_m(pose, place) for t_s, pose in self._samples if from_s < t_s <= until_s), default=0.0
        )
