"""The cells that a campaign has reached, how often, and which instants are worth futures. Pure.

Rule 1: an instant is as rare as the rarest cell that its run has reached there. Of equally rare ones, those
        at which a view forms come first, and then the earlier ones.
Rule 2: of a run that has been played, the rarest instants count. In a run that goes on, an instant has two
        futures where a cell is new, one while few runs have reached it, and after that one with a probability
        that falls with their number.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from clew.guided.cells import Cell
from clew.swarm.draws import Draws

NEW = 2  # futures of an instant at which a cell is new
FEW = 4  # runs that have reached a cell, up to which each instant has a future

ALWAYS = 0.25  # the least probability: each world is new, also where no cell is


class Instant(NamedTuple):
    """An instant of a run."""

    tick: int
    t_s: float
    cells: frozenset[Cell]
    """What the run has reached there, and not before."""
    view_changes: bool
    """Whether a view forms: most rules are about that."""


class Corpus:
    """The cells of all episodes so far."""

    def __init__(self, visits: Mapping[Cell, int] | None = None) -> None:
        self.visits: Counter[Cell] = Counter(visits or {})
        """In how many runs each cell was reached."""

    def __contains__(self, cell: Cell) -> bool:
        return cell in self.visits

    def __len__(self) -> int:
        return len(self.visits)

    def add(self, reached: Iterable[Cell]) -> None:
        """Count the cells of one run."""
        self.visits.update(set(reached))

    def merge(self, visits: Mapping[Cell, int]) -> None:
        """Count the cells of a whole search."""
        self.visits.update(visits)

    def rarest(self, instants: Sequence[Instant], count: int, apart_s: float) -> list[Instant]:
        """The rarest instants of a run, in order of time, at least so far apart."""
        chosen: list[Instant] = []
        for each in sorted(instants, key=self._rarity):
            if len(chosen) < count and all(abs(each.t_s - other.t_s) >= apart_s for other in chosen):
                chosen.append(each)
        return sorted(chosen)

    def _rarity(self, instant: Instant) -> tuple[int, bool, int]:
        """Rule 1. A number of runs counts by its doublings. An early future takes the least time."""
        visits = min(self.visits[cell] for cell in instant.cells)
        return visits.bit_length(), not instant.view_changes, instant.tick

    def worth(self, cells: Collection[Cell], draws: Draws) -> int:
        """Rule 2: how many futures to play from an instant of a run that goes on."""
        rarest = min((self.visits[cell] for cell in cells), default=None)
        if rarest is None:
            return 0
        if rarest == 0:
            return NEW
        return int(rarest <= FEW or draws.chance(max(FEW / rarest, ALWAYS)))
