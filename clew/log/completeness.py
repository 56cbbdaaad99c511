"""Whether a log lacks entries, or has them twice or in disorder: told by their sources' own numbers.

Rule 1: a source's numbers have no hole, and its numbers and times go up.
Rule 2: a robot that was started again begins with `robot.started`, counts from 1, and does not know the time
        yet.
"""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field

from protocol.plain import plain
from protocol.timeline import Entry, RobotStarted

TOLD_MAX = 20
"""Flaws of one sort that are told one by one: who has more looks at the file."""


class Told:
    """Sentences, plain, of which the first are kept and the rest are counted."""

    def __init__(self) -> None:
        self.first: list[str] = []
        self._more_count = 0

    def add(self, sentence: str) -> None:
        """Keep it, or count it."""
        if len(self.first) < TOLD_MAX:
            self.first.append(plain(sentence))
        else:
            self._more_count += 1

    @property
    def more(self) -> Iterator[str]:
        """How many there are behind the first."""
        if self._more_count:
            yield f"and {self._more_count} more like these"

    def __iter__(self) -> Iterator[str]:
        yield from self.first
        yield from self.more


class Numbers:
    """Which numbers have been seen, as runs without a hole; 0 is there from the start."""

    def __init__(self) -> None:
        self._starts, self._ends = [0], [0]
        self.twice: int | None = None
        """The first that was seen more than once."""

    def add(self, number: int) -> None:
        """A number has been seen."""
        if number == self._ends[-1] + 1:
            self._ends[-1] = number  # nearly always
            return
        after = bisect_right(self._starts, number)
        if number <= self._ends[after - 1]:
            self.twice = number if self.twice is None else self.twice
            return
        self._starts.insert(after, number)
        self._ends.insert(after, number)
        for later in (after + 1, after):
            if later < len(self._starts) and self._starts[later] == self._ends[later - 1] + 1:
                self._ends[later - 1] = self._ends[later]
                del self._starts[later], self._ends[later]

    def flaws(self) -> Iterator[str]:
        """What is missing, and what is there twice."""
        newest = self._ends[-1]
        seen_count = sum(end - start + 1 for start, end in zip(self._starts, self._ends, strict=True))
        if missing_count := newest + 1 - seen_count:
            yield f"{missing_count} of {newest} entries are missing, the first is number {self._ends[0] + 1}"
        if self.twice is not None:
            yield f"entry number {self.twice} stands in the log more than once"


@dataclass(slots=True, eq=False)
class _Source:
    lives: list[Numbers] = field(default_factory=lambda: [Numbers()])
    began: Entry | None = None
    """The first entry of its newest life, where that is on record."""
    n: int = 0
    t_s: float = 0.0


class Completeness:
    """Hears a log's entries in its order and knows what is missing, or too much."""

    def __init__(self) -> None:
        self._sources: dict[str, _Source] = {}
        self._disorder = Told()

    def hear(self, source: str, entry: Entry) -> None:
        """The next entry of the log."""
        known = self._sources.get(source) or self._new(source)
        if entry.n == 1 and isinstance(entry.record, RobotStarted) and entry != known.began:
            if known.n:
                known.lives.append(Numbers())
            known.began, known.n, known.t_s = entry, 0, 0.0
        self.number(source, entry.n, entry.t_s)

    def number(self, source: str, n: int, t_s: float) -> None:
        """The next line bears this number, whatever else stands in it."""
        known = self._sources.get(source) or self._new(source)
        if n < known.n or t_s < known.t_s:
            self._disorder.add(f"{source}: entry {n} of t={t_s} s stands behind {known.n} of t={known.t_s} s")
        known.lives[-1].add(n)
        known.n, known.t_s = n, t_s

    def _new(self, source: str) -> _Source:
        self._sources[source] = known = _Source()
        return known

    def flaws(self) -> Iterator[str]:
        """What is wrong with what was heard."""
        yield from self._disorder
        numbers = Told()
        for source, known in sorted(self._sources.items()):
            for life in known.lives:
                for flaw in life.flaws():
                    numbers.add(f"{source}: {flaw}")
        yield from numbers
