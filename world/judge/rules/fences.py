"""The fences of a run in order, and F3: how they may follow each other.

Rule 1: fences go forward by generation, robot and turn. A new generation is the next one; within a generation
        another robot's epoch replaces one in which no turn was given.
Rule 2: a new epoch begins with turn 0, when nobody may move. Each turn is the next one, put by the same life
        of the coordinator. No turn follows ALL.
Rule 3: after a stop only robot 0, the operator or a restarted world, changes the fence.
"""

from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

from protocol.fence import NOBODY_NUMBER, NUMBERS, May
from protocol.timeline import Entry, FenceChanged, PromiseBroken
from world.judge.rules.claims import ROUNDING_S
from world.judge.rules.rule import Dated

FIRST = FenceChanged(epoch=0, turn=0, may=May.NOBODY, coordinator=NOBODY_NUMBER, life="")
"""The fence of a run that begins; no entry tells of it."""


@dataclass(slots=True)
class Fences:
    """All fences of a run; a fence is given by its index."""

    changes: list[FenceChanged] = field(default_factory=lambda: [FIRST])
    times_s: list[float] = field(default_factory=lambda: [0.0])
    of_epoch: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list, {0: [0]}))
    """The fences of each epoch."""
    _driven: dict[int, int] = field(default_factory=dict)
    """The first fence of each epoch that lets all move."""

    def __getitem__(self, index: int) -> FenceChanged:
        return self.changes[index]

    @property
    def newest(self) -> int:
        """The index of the fence in force so far."""
        return len(self.changes) - 1

    @property
    def now(self) -> FenceChanged:
        """The fence in force so far."""
        return self.changes[-1]

    def hear(self, t_s: float, change: FenceChanged) -> None:
        """The world has changed the fence."""
        self.changes.append(change)
        self.times_s.append(t_s)
        self.of_epoch[change.epoch].append(self.newest)
        if change.may is May.ALL:
            self._driven.setdefault(change.epoch, self.newest)

    def during(self, from_s: float, to_s: float) -> range:
        """The fences in force between two times, the second not included."""
        first = max(bisect_right(self.times_s, from_s + ROUNDING_S) - 1, 0)
        return range(first, max(bisect_left(self.times_s, to_s - ROUNDING_S), first + 1))

    def begun_s(self, epoch: int) -> float:
        """When an epoch came into force; infinite if it never did."""
        indices = self.of_epoch.get(epoch)
        return self.times_s[indices[0]] if indices else float("inf")

    def all_of(self, epoch: int) -> int | None:
        """The fence under which the strand of an epoch drives, if there is one."""
        return self._driven.get(epoch)


class FenceOrder:
    """F3 in the sequence of fences."""

    kinds = frozenset[type]({FenceChanged})

    def __init__(self) -> None:
        self._before = FIRST

    def hear(self, _: str, entry: Entry) -> Iterator[Dated]:
        """Compare a fence to the one before."""
        change = entry.record
        assert isinstance(change, FenceChanged)
        before, self._before = self._before, change
        same = change.epoch == before.epoch
        for why in _of_turn(before, change) if same else _of_epoch(before, change):
            # A violation names a robot; a fence of nobody is counted for the first.
            yield entry.t_s, PromiseBroken(invariant="F3", robot=max(change.coordinator, 1), why=why)

    def close(self) -> Iterator[Dated]:
        """Nothing is open."""
        return iter(())


def _of_turn(before: FenceChanged, change: FenceChanged) -> Iterator[str]:
    """Rule 2 within an epoch."""
    told = f"turn {change.turn} of epoch {change.epoch}"
    if change.turn != before.turn + 1:
        yield f"{told} follows turn {before.turn}"
    if before.may in {May.ALL, May.STOPPED}:
        yield f"{told} follows a fence that is the last of its epoch"
    if (change.coordinator, change.life) != (before.coordinator, before.life):
        yield f"{told} was put by another life than the epoch's coordinator"
    if change.may is May.STOPPED:
        yield f"{told} stops all robots, which only the operator may do in an epoch of its own"
    if change.may is May.ONE and not (change.named and change.named_life):
        yield f"{told} names no life of a robot"


def _of_epoch(before: FenceChanged, change: FenceChanged) -> Iterator[str]:
    """Rules 1 to 3 for a new epoch."""
    generation, robot = divmod(change.epoch, NUMBERS)
    generation_before, robot_before = divmod(before.epoch, NUMBERS)
    told = f"epoch {change.epoch}"
    if generation == generation_before and (robot < robot_before or before.turn > 0):
        yield f"{told} replaces turn {before.turn} of epoch {before.epoch}"
    if generation not in {generation_before, generation_before + 1}:
        yield f"{told} is not of the generation after that of epoch {before.epoch}"
    if before.may is May.STOPPED and robot != NOBODY_NUMBER:
        yield f"{told} was proposed over a stop"
    if change.turn != 0 or change.may not in {May.NOBODY, May.STOPPED}:
        yield f"{told} begins with turn {change.turn}, under which {change.may} may move"
    if change.may is May.STOPPED and robot != NOBODY_NUMBER:
        yield f"{told} stops all robots, which only the operator may do"
    if change.coordinator != robot or bool(change.life) != (robot != NOBODY_NUMBER):
        yield f"{told} does not name its coordinator and the coordinator's life"
    if change.cause is None:
        yield f"{told} has no cause"
