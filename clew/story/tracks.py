"""Where bodies were, in few places: what lies on the straight and even way between two others is left out.

Bodies drive straight and turn evenly, so this leaves some tenth of all samples, and nothing that shows.

Rule 1: a body that only turns is not sampled before, but at every odometry while it does. So it stood until
        one period before a sample that finds it turned.
"""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from protocol.arrays import Flags, Floats
from protocol.timeline import PoseSampled
from world.bodies.arena import ODOMETRY_TICKS, TICK_S

ODOMETRY_PERIOD_S = ODOMETRY_TICKS * TICK_S
EVEN = np.array([1e-7, 1e-7, 1e-6])  # m, m, rad: nearer than this to the way between its neighbours is on it
SLACK = np.array([4e-4, 4e-4, 1e-3])  # m, m, rad: what is left out is no further off; rounding adds 5e-4


@dataclass(slots=True)
class Tracks:
    """The newest samples of each body, until they are taken."""

    _samples: dict[int, "array[float]"] = field(default_factory=dict)
    _last: dict[int, Floats] = field(default_factory=dict)
    """(1, 4): the newest that was taken."""

    def hear(self, t_s: float, pose: PoseSampled) -> None:
        """Take a sample in; those of one body come in their order."""
        robot = pose.robot
        samples = self._samples.get(robot)
        if samples is None:
            samples = self._samples[robot] = array("d")
        samples.extend((t_s, pose.x_m, pose.y_m, pose.heading_rad))

    def take(self) -> Iterator[tuple[int, Floats]]:
        """The samples of each body since the last time, `(n, 4)`: t, x, y, heading, which is unwound."""
        for robot, samples in sorted(self._samples.items()):
            new = np.array(samples).reshape(-1, 4)
            rows = np.vstack((self._last.get(robot, new[:1]), new))
            rows[:, 3] = np.unwrap(rows[:, 3])
            self._last[robot] = rows[-1:]
            yield robot, _with_stands(rows)[1:]
        self._samples.clear()


def _with_stands(rows: Floats) -> Floats:
    """Rule 1."""
    same = (rows[1:, 1:] == rows[:-1, 1:]).all(axis=1)
    turned = (rows[1:, 1:3] == rows[:-1, 1:3]).all(axis=1) & ~same
    late = np.flatnonzero(turned & (np.diff(rows[:, 0]) > 1.5 * ODOMETRY_PERIOD_S))
    stands = rows[late].copy()
    stands[:, 0] = rows[late + 1, 0] - ODOMETRY_PERIOD_S
    return np.insert(rows, late + 1, stands, axis=0)


def needed(rows: Floats) -> Flags:
    """Which samples the others do not tell; the first and the last always."""
    kept: Flags = np.ones(len(rows), dtype=bool)
    if len(rows) < 3:
        return kept
    t_s, places = rows[:, 0], rows[:, 1:]
    whole_s = t_s[2:] - t_s[:-2]
    share = ((t_s[1:-1] - t_s[:-2]) / np.where(whole_s > 0.0, whole_s, 1.0))[:, None]
    off = np.abs(places[:-2] + share * (places[2:] - places[:-2]) - places[1:-1])
    kept[1:-1] = (off > EVEN).any(axis=1) | (whole_s <= 0.0)
    while True:  # what is a little uneven everywhere bends in the end: there, every sample is needed
        told = np.column_stack([np.interp(t_s, t_s[kept], each[kept]) for each in places.T])
        wrong = (np.abs(told - places) > SLACK).any(axis=1) & ~kept
        if not wrong.any():
            return kept
        kept |= wrong
