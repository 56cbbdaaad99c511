"""The cells that a campaign has reached, how often, and how many futures an instant is worth. Pure.

Rule: an instant is as rare as the rarest cell that the fleet is in there. It has two futures while few runs
      have reached that cell, and after that one.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping

from clew.guided.cells import Cell

FEW = 4  # runs


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

    def worth(self, cells: Collection[Cell]) -> int:
        """How many futures to play from an instant at which the fleet is in these cells."""
        return 2 if min((self.visits[cell] for cell in cells), default=0) <= FEW else 1
