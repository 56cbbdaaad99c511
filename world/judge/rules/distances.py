"""S1 and S2 along all moves, by the same monitor that watches live runs; and the metres driven."""

from collections.abc import Iterable, Iterator

import numpy as np

from protocol.keys import WORLD
from protocol.timeline import Entry, PoseSampled
from world.judge.monitor import Monitor
from world.judge.moves import Intervals, Moves
from world.judge.rules.rule import Dated
from world.scenario.scenario import Scenario

MOVES_AT_ONCE = 200  # in a live run the world does nothing else meanwhile: about 10 ms


class Distances:
    """Judges the distances of all hulls."""

    kinds = frozenset[type]({PoseSampled})

    def __init__(self, scenario: Scenario) -> None:
        self.monitor = Monitor.of(scenario)
        self.path_m = 0.0
        """Metres driven by all robots."""
        self._moves = Moves(self.monitor.ground, scenario.fleet.robots, at_once=MOVES_AT_ONCE)

    @property
    def undecided(self) -> int:
        """How many moves are not certain yet."""
        return len(self._moves)

    @property
    def unjudged(self) -> str | None:
        """Why no distance was judged, although bodies were sampled; None: all were."""
        unplaced = self._moves.unplaced
        return f"no distance was judged: robot {unplaced[0]} was never sampled" if unplaced else None

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process a sample."""
        if source == WORLD and isinstance(entry.record, PoseSampled):
            yield from self._watch(self._moves.hear(entry.t_s, entry.record))

    def close(self) -> Iterator[Dated]:
        """The last few seconds."""
        yield from self._watch(self._moves.close())

    def _watch(self, all_intervals: Iterable[Intervals]) -> Iterator[Dated]:
        for intervals in all_intervals:
            yield from self.monitor.watch_all(intervals)
            moves_m = intervals.ends_m - intervals.starts_m
            for driven_m in np.hypot(moves_m[..., 0], moves_m[..., 1]).sum(axis=1).tolist():
                self.path_m += driven_m
