"""The hulls of all fleets on one ground: what each sees of the others, and the monitor between them. Pure.

Rule 1: all bodies move in the same instant: until the last has its new place, all see the old ones.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate

import numpy as np

from protocol.arrays import Floats
from world.geometry.rays import NearDiscs, are_near
from world.judge.between import Between, Encounter
from world.scenario.scenario import Scenario


class AllHulls:
    """Where the bodies of all fleets are: what each sees of the others, and the monitor between them."""

    def __init__(self, scenarios: Mapping[str, Scenario]) -> None:
        fleets = {name: each.fleet for name, each in scenarios.items()}
        self.between = Between({name: (each.robots, each.robot_radius_m) for name, each in fleets.items()})
        """What has come between the fleets."""
        self._rows = dict(zip(fleets, _rows([each.robots for each in fleets.values()]), strict=True))
        """The bodies of each fleet among all."""
        self._hulls: Floats = np.array(
            [(pose.x_m, pose.y_m, each.robot_radius_m) for each in fleets.values() for pose in each.poses()]
        )
        self.between.watch(self._hulls[:, :2], self._hulls[:, :2], t_s=0.0)

    def others_of(self, fleet: str) -> NearDiscs:
        """What shows the hulls of the other fleets at this instant."""
        rows = self._rows[fleet]

        def others(place_m: Floats, within_m: float) -> Floats:
            hulls = np.concatenate((self._hulls[: rows.start], self._hulls[rows.stop :]))
            return hulls[are_near(hulls, place_m, within_m)]

        return others

    def move(self, places_m: Mapping[str, Floats], *, t_s: float) -> list[Encounter]:
        """Put all bodies to their places at the end of a tick; returns new contacts."""
        before_m = self._hulls[:, :2]
        after_m = np.concatenate([places_m[fleet] for fleet in self._rows])
        self._hulls = np.column_stack((after_m, self._hulls[:, 2]))
        return self.between.watch(before_m, after_m, t_s=t_s)


def _rows(robots: Sequence[int]) -> Iterator[slice]:
    """The bodies of each fleet, which stand one behind the other."""
    return (slice(end - each, end) for each, end in zip(robots, accumulate(robots), strict=True))
