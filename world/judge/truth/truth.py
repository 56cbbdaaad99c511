"""What robots record in one run, held against true poses: S4, A1, A2, and who may record it: P1, P7."""

from collections.abc import Iterator
from typing import get_args

from protocol.keys import WORLD, robot_number
from protocol.timeline import Entry, LeaderSucceeded, Record, StrandFormed, StrandHealed
from world.judge.rules.rule import Dated
from world.judge.truth.arrivals import Arrivals, Places
from world.judge.truth.clearances import Clearances
from world.judge.truth.voices import Voices
from world.scenario.scenario import Scenario

BY_FORMATION = LeaderSucceeded | StrandFormed | StrandHealed
"""What P1 and F4 judge by the formation: here it only does not count."""


class Truth:
    """What robots record: a rule of the judge, whose checks may wait for other entries."""

    kinds = frozenset[type](get_args(Record))

    def __init__(self, scenario: Scenario) -> None:
        law, fleet = scenario.law, scenario.fleet
        self._voices = Voices()
        self._arrivals = Arrivals(Places.of(scenario))
        self._clearances = (
            Clearances(scenario.ground, radius_m=fleet.robot_radius_m, mu0_m=law.mu0_m)
            if law.promises_clearance
            else None
        )
        self._now_s = 0.0

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an entry; returns the violations that it shows."""
        robot = robot_number(source)
        breach = self._voices.hear(source, entry)
        if breach is not None:
            if not isinstance(entry.record, BY_FORMATION):
                yield entry.t_s, breach
        elif source == WORLD:
            self._now_s = entry.t_s
            yield from self._arrivals.hear_world(entry)
            if self._clearances is not None:
                yield from self._clearances.hear_world(entry)
        elif robot is not None:
            yield from self._arrivals.hear_robot(robot, entry, self._voices.epoch_of(robot))
            if self._clearances is not None:
                yield from self._clearances.hear_robot(robot, entry)

    def close(self) -> Iterator[Dated]:
        """The violations that the end shows: there are no more entries."""
        if self._clearances is not None:
            yield from self._clearances.close(self._now_s)

    def decide(self) -> Iterator[Dated]:
        """The run is over: the violations of what still waits for an entry of another source."""
        yield from self._voices.close()
        yield from self._arrivals.close()
        if self._clearances is not None:
            yield from self._clearances.decide()
