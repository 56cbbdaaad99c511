"""Whether entries are missing, doubled or out of order in a log, by the numbers that each source gives them.

Rule 1: the numbers of a source have no hole, and its numbers and times increase.
Rule 2: a robot that was started again begins with `robot.started`, counts from 1, and does not know the time
        yet.
Rule 3: when a run has ended, the last entry of each robot that was there is its `traffic.counted`. Numbers
        alone do not show that the last ones are missing.
"""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field

from protocol.keys import WORLD, robot_name
from protocol.plain import plain
from protocol.timeline import (
    Entry,
    Record,
    RobotAppeared,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RunEnded,
    TrafficCounted,
)

OF_THE_END = frozenset[type](
    {RobotAppeared, RobotDied, RobotRestarted, RobotReturned, RunEnded, TrafficCounted}
)
"""What rule 3 is about."""
TOLD_MAX = 20
"""How many flaws of one kind are listed; the rest is counted."""

LAST_MISSING = "its last entries are missing: the one in which it has counted messages"


class Told:
    """Keeps the first sentences, and counts the rest."""

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
        """How many more there are."""
        if self._more_count:
            yield f"and {self._more_count} more like these"

    def __iter__(self) -> Iterator[str]:
        yield from self.first
        yield from self.more


class Numbers:
    """Which numbers have been seen, as ranges without a hole; 0 is in them from the start."""

    def __init__(self) -> None:
        self._starts, self._ends = [0], [0]
        self.twice: int | None = None
        """The first number that was seen twice."""

    def add(self, number: int) -> None:
        """A number has been seen."""
        if number == self._ends[-1] + 1:
            self._ends[-1] = number  # the usual case
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
        """Missing and doubled numbers."""
        newest = self._ends[-1]
        seen_count = sum(end - start + 1 for start, end in zip(self._starts, self._ends, strict=True))
        if missing_count := newest + 1 - seen_count:
            yield f"{missing_count} of {newest} entries are missing, the first is number {self._ends[0] + 1}"
        if self.twice is not None:
            yield f"entry {self.twice} is in the log more than once"


@dataclass(slots=True, eq=False)
class _Source:
    lives: list[Numbers] = field(default_factory=lambda: [Numbers()])
    began: Entry | None = None
    """The first entry of its newest process, if it is in the log."""
    n: int = 0
    t_s: float = 0.0

    def begin(self, entry: Entry) -> None:
        """Its next process begins with this entry."""
        if self.n:
            self.lives.append(Numbers())
        self.began, self.n, self.t_s = entry, 0, 0.0

    def go_on(self, n: int, t_s: float) -> None:
        """Its next entry has this number and time."""
        self.lives[-1].add(n)
        self.n, self.t_s = n, t_s


class Completeness:
    """Finds missing and doubled entries; gets the entries in the order of the log."""

    def __init__(self) -> None:
        self._sources: dict[str, _Source] = {}
        self._disorder = Told()
        self._open: set[str] = set()
        """The robots that are there, and have not told their last entry."""
        self._told: set[str] = set()
        """Those that have."""
        self._is_over = False

    def hear(self, source: str, entry: Entry) -> None:
        """The next entry of the log."""
        known = self._sources.get(source) or self._new(source)
        if entry.n == 1 and isinstance(entry.record, RobotStarted) and entry != known.began:
            known.begin(entry)
        self.number(source, entry.n, entry.t_s)
        if type(entry.record) in OF_THE_END:
            self._hear_of_end(source, entry.record)

    def _hear_of_end(self, source: str, record: Record) -> None:
        """Rule 3."""
        match record:
            case TrafficCounted():
                self._told.add(source)
            case RunEnded() if source == WORLD:
                self._is_over = True
            case RobotDied(robot=robot) if source == WORLD:
                self._open.discard(robot_name(robot))
            case RobotRestarted(robot=robot) if source == WORLD:
                self._open.add(robot_name(robot))
                self._told.discard(robot_name(robot))
            case RobotAppeared(robot=robot) | RobotReturned(robot=robot) if source == WORLD:
                self._open.add(robot_name(robot))
            case _:
                pass  # of a source that has no say in it

    def number(self, source: str, n: int, t_s: float) -> None:
        """The next line has this number, even if the rest of the line cannot be read."""
        known = self._sources.get(source) or self._new(source)
        if n < known.n or t_s < known.t_s:
            self._disorder.add(
                f"{source}: entry {n} of t={t_s} s comes after entry {known.n} of t={known.t_s} s"
            )
        known.go_on(n, t_s)

    def _new(self, source: str) -> _Source:
        self._sources[source] = known = _Source()
        return known

    def flaws(self) -> Iterator[str]:
        """Flaws in the entries so far."""
        yield from self._disorder
        numbers = Told()
        for source, known in sorted(self._sources.items()):
            for life in known.lives:
                for flaw in life.flaws():
                    numbers.add(f"{source}: {flaw}")
        for source in sorted(self._open - self._told) if self._is_over else ():
            numbers.add(f"{source}: {LAST_MISSING}")
        yield from numbers
