"""The ground that several fleets share: what each sees of the others, and the monitor between them. Pure.

Rule 1: all bodies move in the same instant: until the last has its new place, all see the old ones.
"""

from collections.abc import Callable, Mapping

import numpy as np

from protocol.arrays import Floats
from world.judge.between import Between, Encounter
from world.scenario.scenario import Scenario


class Ground:
    """Where the bodies of all fleets are: what each sees of the others, and the monitor between them."""

    def __init__(self, scenarios: Mapping[str, Scenario]) -> None:
        fleets = {name: each.fleet for name, each in scenarios.items()}
        self.between = Between({name: (each.robots, each.robot_radius_m) for name, each in fleets.items()})
        """What has come between the fleets."""
        self._hulls = {
            name: np.array([(pose.x_m, pose.y_m, each.robot_radius_m) for pose in each.poses()])
            for name, each in fleets.items()
        }
        self.between.watch(self._places_m(), self._places_m(), t_s=0.0)

    def others_of(self, fleet: str) -> Callable[[], Floats]:
        """What shows the hulls of the other fleets, x, y, radius (k, 3) [world frame], at this instant."""
        return lambda: np.concatenate([hulls for name, hulls in self._hulls.items() if name != fleet])

    def move(self, places_m: Mapping[str, Floats], *, t_s: float) -> list[Encounter]:
        """Put all bodies to their places at the end of a tick; returns new contacts."""
        before_m = self._places_m()
        for name, hulls in self._hulls.items():
            self._hulls[name] = np.column_stack((places_m[name], hulls[:, 2]))
        return self.between.watch(before_m, self._places_m(), t_s=t_s)

    def _places_m(self) -> Floats:
        return np.concatenate([hulls[:, :2] for hulls in self._hulls.values()])
