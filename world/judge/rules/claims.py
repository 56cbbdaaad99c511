"""Checks that await entries of other sources.

The sources of a timeline have no common order: a robot's entry may be recorded long after its time.

Rule 1: a check that the entries so far satisfy is done at once. More entries must not be able to break it.
Rule 2: any other check names the sources that may still satisfy it. It is made again with each of their
        entries, and for the last time when each of them has recorded an entry of a later time: the entries of
        a source come in order, so all that it had to say by the check's time is there.
Rule 3: what is undecided at the end of the timeline is then checked for the last time.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from protocol.timeline import Entry, PromiseBroken
from world.judge.rules.rule import Dated

ROUNDING_S = 1e-9


@dataclass(eq=False, slots=True)
class Claim:
    """An undecided check."""

    t_s: float
    epoch: int
    check: "Check"
    heard_s: dict[str, float] = field(default_factory=dict)
    """By source: the time of its first entry that is later than the claim."""
    is_last: bool = False
    """Whether the check is made for the last time: then it must decide."""
    awaits: frozenset[str] = frozenset()
    """The sources under which it is kept."""

    def look(self, *, last: bool) -> "Iterable[PromiseBroken] | frozenset[str]":
        """Make the check; for the last time: then it decides."""
        self.is_last = last
        return self.check(self)

    def await_under(self, sources: frozenset[str]) -> None:
        """It is kept under these sources."""
        self.awaits = sources

    def heard_after_s(self, source: str) -> float:
        """When the source was first heard after the claim's time; infinite if it was not."""
        return self.heard_s.get(source, math.inf)


Check = Callable[[Claim], Iterable[PromiseBroken] | frozenset[str]]
"""Returns the violations, or the sources that may still show that there is none."""


class Claims:
    """The undecided checks of one run."""

    def __init__(self) -> None:
        self._waiting: dict[str, dict[Claim, None]] = {}
        """By the source whose entries they await."""
        self._newest_s: dict[str, float] = {}
        self._is_over = False

    def __len__(self) -> int:
        return len(self._all())

    @property
    def epochs(self) -> set[int]:
        """The epochs that undecided checks are about."""
        return {claim.epoch for claim in self._all()}

    def judge(self, t_s: float, epoch: int, check: Check) -> Iterator[Dated]:
        """Check something that happened at this time; returns the violations, if it is decided."""
        return self._look(Claim(t_s, epoch, check))

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """An entry has come: make the checks again that await its source."""
        self._newest_s[source] = entry.t_s
        waiting = self._waiting.get(source)
        if not waiting:
            return
        for claim in list(waiting):
            if entry.t_s > claim.t_s + ROUNDING_S:
                claim.heard_s.setdefault(source, entry.t_s)
            yield from self._look(claim)

    def close(self) -> Iterator[Dated]:
        """Rule 3."""
        self._is_over = True
        for claim in self._all():
            yield from self._look(claim)

    def _look(self, claim: Claim) -> Iterator[Dated]:
        found = claim.look(last=self._is_over)
        if isinstance(found, frozenset) and not (awaited := self._awaited(claim, found)):
            found = claim.look(last=True)
        if isinstance(found, frozenset):
            self._park(claim, awaited)
            return
        self._park(claim, frozenset())
        yield from ((claim.t_s, each) for each in found)

    def _awaited(self, claim: Claim, sources: frozenset[str]) -> frozenset[str]:
        """Rule 2: those of the sources that have not been heard later than the claim."""
        for source in sources:
            newest_s = self._newest_s.get(source, -math.inf)
            if newest_s > claim.t_s + ROUNDING_S:
                claim.heard_s.setdefault(source, newest_s)
        return sources - claim.heard_s.keys()

    def _park(self, claim: Claim, sources: frozenset[str]) -> None:
        """Keep a claim under these sources, and under no others."""
        for source in claim.awaits - sources:
            del self._waiting[source][claim]
        for source in sources - claim.awaits:
            self._waiting.setdefault(source, {})[claim] = None
        claim.await_under(sources)

    def _all(self) -> list[Claim]:
        return list({claim: None for waiting in self._waiting.values() for claim in waiting})
