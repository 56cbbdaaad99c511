"""The range sensor of every body; it is read only when its robot asks."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from protocol.arrays import Floats, scan_bearings_rad
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.mission import RAYS_MAX
from protocol.timeline.bodies import RANGES_TOLD_MAX
from protocol.wire.messages import Scan
from world.geometry.rays import NearDiscs, cast, noisy
from world.scenario.scenario import Scenario


class Sensor:
    """Takes scans of obstacles and other bodies; each body has its own random stream of errors."""

    def __init__(self, scenario: Scenario, errors: Sequence[np.random.Generator]) -> None:
        self.directions = scenario.sensor.directions
        """Rays per revolution."""
        self._ground = scenario.ground
        self._movers = scenario.movers
        self._errors = errors
        self._radius_m = scenario.fleet.robot_radius_m
        self._sigma_m = scenario.sensor.range_sigma_m
        self._error_m_max = scenario.range_error_m_max
        self._range_m_max = scenario.range_m_used
        self._others: NearDiscs | None = None

    def share_ground(self, others: NearDiscs) -> None:
        """See the hulls of other fleets, too."""
        self._others = others

    def read(
        self, body: int, pose: Pose, places_m: Floats, *, fence: Fence, now_s: float, revolutions: int
    ) -> tuple[Scan, Floats]:
        """The scan of one body at this time and fence, with all bodies at these places [world frame].

        Its ranges come as an array, too.
        """
        rays = self.directions * max(1, min(revolutions, RAYS_MAX // self.directions))
        others_m = np.delete(places_m, body, axis=0)
        discs = np.column_stack((others_m, np.full(len(others_m), self._radius_m)))
        if self._others is not None:
            discs = np.vstack((discs, self._others(places_m[body], self._range_m_max)))
        ranges_m = cast(
            self._movers.among(self._ground, now_s),
            places_m[body],
            scan_bearings_rad(rays),
            range_m_max=self._range_m_max,
            discs=discs,
        )
        ranges_m = noisy(
            ranges_m,
            self._errors[body],
            sigma_m=self._sigma_m,
            error_m_max=self._error_m_max,
            range_m_max=self._range_m_max,
        )
        return Scan(t_s=now_s, pose=pose, fence=fence, ranges_m=tuple(ranges_m.tolist())), ranges_m

    def hits(self, ranges_m: Floats) -> int:
        """The number of rays with a hit."""
        return int(np.count_nonzero(ranges_m < self._range_m_max))


def told(ranges_m: Floats) -> tuple[float, ...]:
    """The ranges of a scan to record: of every n-th ray, with the least n that divides them and fits."""
    return tuple(np.round(ranges_m[:: _stride(len(ranges_m))], 3).tolist())


@cache
def _stride(rays: int) -> int:
    return next(n for n in range(1, rays + 1) if rays % n == 0 and rays // n <= RANGES_TOLD_MAX)
