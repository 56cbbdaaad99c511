"""The cells that a campaign has reached, how often, and which held run to go on from. Pure.

Rule 1: a held run is worth the rarity of its rarest cell, halved by each future that it has had: rare cells
        first, and none is played for ever.
Rule 2: the numbers of its cells, which are as good as drawn, make its worth differ by up to two times. Where
        everything is new, the first seconds of an episode would otherwise have all futures.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from clew.guided.cells import Cell


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


LUCK = 997  # a prime: sums of cells are spread evenly over it


@dataclass(slots=True)
class Held:
    """A run that is held at an instant, to be gone on from."""

    slot: int
    from_s: float
    cells: frozenset[Cell]
    """The cells for which it was held."""
    depth: int
    played: int = 0

    def worth(self, corpus: Corpus) -> float:
        """Rules 1 and 2; the same for the same run in every search."""
        rarest = min(corpus.visits[cell] for cell in self.cells)
        luck = sum(self.cells) % LUCK / LUCK
        return 0.5**self.played / max(1, rarest) * (1.0 + luck)


@dataclass(slots=True)
class Choice:
    """The held runs of one search, and which is next."""

    corpus: Corpus
    futures_max: int
    held: list[Held] = field(default_factory=list)

    def best(self) -> Held | None:
        """The run to go on from; None if each has had its futures."""
        left = [each for each in self.held if each.played < self.futures_max]
        return max(left, key=lambda each: each.worth(self.corpus), default=None)

    def worst(self) -> Held | None:
        """The run to give up first."""
        return min(self.held, key=lambda each: each.worth(self.corpus), default=None)
