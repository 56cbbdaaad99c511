"""Cells: what a pair of robots is in, coarse enough to recur. Pure.

Rule 1: a cell names no robot, no time and no place, so that different episodes reach the same cells.
Rule 2: all that is known of a robot's core comes by `Seen`, and of the faults by `Troubles`. When the states
        of a robot change, only what fills these in changes (`look`).
"""

from collections.abc import Collection, Iterator, Sequence
from functools import cache
from hashlib import blake2b
from itertools import combinations
from typing import Protocol

Cell = int
"""64 bits that stand for a cell, the same on any machine."""
Half = tuple[str | bool, ...]
CELL_BYTES = 8


class Seen(Protocol):
    """One robot, as far as a cell tells it apart."""

    @property
    def robot(self) -> int:
        """Its number."""

    @property
    def state(self) -> str:
        """What it is in; robots without a process have a state, too."""

    @property
    def fence(self) -> tuple[int, int, int]:
        """The fence that its odometry tells: generation and robot of the epoch, and the turn."""

    @property
    def role(self) -> str:
        """Its part in the view and in the strand."""

    @property
    def drives(self) -> bool:
        """Whether its body is under way."""

    @property
    def named(self) -> Collection[int]:
        """The robots that may move by that fence."""

    @property
    def bound(self) -> Collection[int]:
        """The robots that have reported to it, and its neighbours."""

    @property
    def silent(self) -> Collection[int]:
        """The neighbours that it has not heard for too long."""


class Troubles(Protocol):
    """The faults in progress."""

    def of(self, robot: int) -> str:
        """The worst that a robot suffers now; empty if nothing."""

    def between(self, one: int, other: int) -> bool:
        """Whether messages from one robot to the other are cut off."""


def cells(fleet: Sequence[Seen], troubles: Troubles) -> Iterator[Cell]:
    """The cells of all pairs."""
    for one, other in combinations(fleet, 2):
        halves = (_half(one, other, troubles), _half(other, one, troubles))
        yield _cell(halves if halves[0] <= halves[1] else halves[::-1])


def _half(one: Seen, other: Seen, troubles: Troubles) -> Half:
    """The pair as seen from one of the two."""
    newer = (one.fence[:2] > other.fence[:2], one.fence > other.fence)
    sees = (other.robot in one.named, other.robot in one.bound, other.robot in one.silent)
    suffers = (troubles.of(one.robot), troubles.between(one.robot, other.robot))
    return (one.state, one.role, one.drives, *newer, *sees, *suffers)


@cache
def _cell(halves: tuple[Half, ...]) -> Cell:
    """The number of a cell. A campaign reaches some thousand: the cache stays small."""
    return int.from_bytes(blake2b(repr(halves).encode(), digest_size=CELL_BYTES).digest(), "big")
