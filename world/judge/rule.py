"""What a rule of the judge is: entries in, violations out."""

from collections.abc import Iterable
from typing import Protocol

from protocol.timeline import Entry, PromiseBroken

Dated = tuple[float, PromiseBroken]
"""A violation and its time."""


class Rule(Protocol):
    """Judges some invariants of one run, entry by entry, in the order of the timeline's lines.

    It keeps only what later entries may need: a run of a million entries must not need a million of them.
    """

    def hear(self, source: str, entry: Entry) -> Iterable[Dated]:
        """Process an entry; returns the violations that are certain now."""
        ...

    def close(self) -> Iterable[Dated]:
        """The timeline is over: the violations that were not certain before. Its cost must not grow."""
        ...
