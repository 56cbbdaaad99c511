"""Cells: what a fleet is in, coarse enough to recur. Pure.

Rule 1: a cell names no robot, no time and no place, so that different episodes reach the same cells.
Rule 2: all that is known of a robot's core comes by `Seen`, and of the fence by `View`. When the states of a
        robot change, only what fills these in changes (`look`).
Rule 3: there is a cell for each robot within its fleet, and one for each pair of which one is on the move or
        has a turn. A cell for each pair or for the whole fleet would make almost every instant a new one.
"""

from collections.abc import Iterator, Sequence
from functools import cache
from hashlib import blake2b
from itertools import permutations
from typing import NamedTuple

Cell = int
"""64 bits that stand for a cell, the same on any machine."""
CELL_BYTES = 8


class Seen(NamedTuple):
    """One robot, as far as a cell tells it apart."""

    state: str
    """What it is in; robots without a process have a state, too."""
    role: str
    """Its part in the view and in the strand."""
    drives: bool
    """Whether its body is under way."""
    behind: str
    """How far the fence that its odometry has told is behind the fence in force: by an epoch, by a turn."""
    named: bool
    """Whether the fence in force names it alone."""
    trouble: str
    """The worst fault that it suffers now; empty if none."""
    silent: int
    """How many neighbours it has not heard for too long."""


class View(NamedTuple):
    """The fence in force, and how far its view has come."""

    may: str
    phase: str
    """The coordinator's; empty: nobody coordinates it any more."""
    turns: int
    """How many turns were put, up to `TURNS_MAX`."""


TURNS_MAX = 3  # a view of which later turns differ from earlier ones only by how many were before


def cells(view: View, fleet: Sequence[Seen]) -> Iterator[Cell]:
    """The cells that the fleet is in."""
    troubled = min(2, sum(bool(each.trouble) for each in fleet))
    moving = any(each.drives for each in fleet)
    for each in fleet:
        yield _cell((view, moving, troubled, each))
    for one, other in permutations(fleet, 2):
        if one.drives or one.named:
            yield _cell(
                (view.may, one.state, one.behind, one.trouble, other.state, other.behind, other.trouble)
            )


@cache
def _cell(what: tuple[object, ...]) -> Cell:
    """The number of a cell. A campaign reaches some thousand: the cache stays small."""
    return int.from_bytes(blake2b(repr(what).encode(), digest_size=CELL_BYTES).digest(), "big")
