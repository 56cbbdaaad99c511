"""What a rule of the judge is: entries in, violations out; and how a violation is made."""

from collections.abc import Iterable
from typing import Protocol

from protocol.timeline import Entry, PromiseBroken

Dated = tuple[float, PromiseBroken]
"""A violation and its time."""


class Rule(Protocol):
    """Judges some invariants of one run, entry by entry, in the order of the timeline's lines.

    It keeps only what later entries may need: a run of a million entries must not need a million of them.
    A check that needs entries of another source goes to `claims.Claims`, which holds it until they are there.
    """

    kinds: frozenset[type]
    """The records that it hears."""

    def hear(self, source: str, entry: Entry) -> Iterable[Dated]:
        """Process an entry of these kinds; returns the violations that are certain now."""
        ...

    def close(self) -> Iterable[Dated]:
        """The timeline is over: the violations that were not certain before. Its cost must not grow."""
        ...


class Waiting(Protocol):
    """Keeps checks that wait for entries of other sources."""

    def decide(self) -> Iterable[Dated]:
        """The run is over, and rules are closed: the violations of all checks that still wait.

        It is not called if the log ends before its run: then an awaited entry may just not be written.
        """
        ...


def broken(invariant: str, robot: int, why: str, other: int | None = None) -> PromiseBroken:
    """A violation without a length."""
    return PromiseBroken(invariant=invariant, robot=robot, other=other, why=why)


def breach_of(
    invariant: str, robot: int, measured_m: float, required_m: float, why: str, *, other: int | None = None
) -> PromiseBroken:
    """A violation with a length."""
    return PromiseBroken(
        invariant=invariant,
        robot=robot,
        other=other,
        measured_m=measured_m,
        required_m=required_m,
        why=why,
    )
