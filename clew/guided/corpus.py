"""The cells that a campaign has reached, how often, and how many futures an instant is worth. Pure.

Rule 1: an instant is worth as much as its rarest cell is rare: two futures where that is new, one while few
        runs have reached it, and after that one with a probability that falls with their number.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping

from clew.guided.cells import Cell
from clew.swarm.draws import Draws

NEW = 2  # futures of an instant at which a cell is new
FEW = 4  # runs that have reached a cell, up to which each instant has a future

ALWAYS = 0.25  # the least probability: each world is new, also where no cell is


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

    def worth(self, cells: Collection[Cell], draws: Draws) -> int:
        """Rule 1: how many futures to play from an instant at which these cells were reached."""
        rarest = min((self.visits[cell] for cell in cells), default=None)
        if rarest is None:
            return 0
        if rarest == 0:
            return NEW
        return int(rarest <= FEW or draws.chance(max(FEW / rarest, ALWAYS)))
