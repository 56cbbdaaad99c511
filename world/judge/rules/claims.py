"""Checks that await entries of other sources.

The sources of a timeline have no common order: a robot's entry may be recorded long after its time.

Rule 1: a check that the entries so far satisfy is done at once. More entries must not be able to break it.
Rule 2: any other check names the sources that may still satisfy it, and is made again with each of their
        entries. A source can say nothing more about a check once it has recorded an entry of a later time,
        because its entries come in order; at the end of the timeline no source can.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

from protocol.timeline import Entry, PromiseBroken
from world.judge.rules.rule import Dated

ROUNDING_S = 1e-9


class Claim:
    """An undecided check."""

    def __init__(self, t_s: float, epoch: int, check: "Check", newest_s: Mapping[str, float]) -> None:
        self.t_s = t_s
        self.epoch = epoch
        self.check = check
        self._newest_s = newest_s
        """The times of the newest entries, by source."""
        self._heard_s: dict[str, float] = {}
        self._is_over = False

    def heard_after_s(self, source: str) -> float:
        """When the source was first heard after the claim's time; infinite if it was not."""
        newest_s = self._newest_s.get(source, -math.inf)
        if newest_s > self.t_s + ROUNDING_S:
            self._heard_s.setdefault(source, newest_s)
        return self._heard_s.get(source, math.inf)

    def may_hear(self, source: str) -> bool:
        """Whether the source may still record what it had to say by the claim's time."""
        return not self._is_over and self.heard_after_s(source) == math.inf

    def awaiting(self, source: str) -> "list[PromiseBroken] | frozenset[str]":
        """What a check returns that only this source can make fail: nothing, once it cannot any more."""
        return frozenset({source}) if self.may_hear(source) else []

    def end(self) -> None:
        """The timeline is over."""
        self._is_over = True


Check = Callable[[Claim], Iterable[PromiseBroken] | frozenset[str]]
"""Returns the violations, or the sources that may still show that there is none."""


class Claims:
    """The undecided checks of one run."""

    def __init__(self) -> None:
        self._awaits: dict[Claim, frozenset[str]] = {}
        self._waiting: dict[str, dict[Claim, None]] = {}
        """By the source whose entries they await."""
        self._newest_s: dict[str, float] = {}

    def __len__(self) -> int:
        return len(self._awaits)

    @property
    def epochs(self) -> set[int]:
        """The epochs that undecided checks are about."""
        return {claim.epoch for claim in self._awaits}

    def oldest_s(self, epoch: int) -> float:
        """The time of the oldest undecided check of an epoch; infinite without one."""
        return min((claim.t_s for claim in self._awaits if claim.epoch == epoch), default=math.inf)

    def judge(self, t_s: float, epoch: int, check: Check) -> Iterator[Dated]:
        """Check something that happened at this time; returns the violations, if it is decided."""
        return self._look(Claim(t_s, epoch, check, self._newest_s))

    def hear(self, source: str, entry: Entry) -> Iterable[Dated]:
        """An entry has come: make the checks again that await its source."""
        self._newest_s[source] = entry.t_s
        waiting = self._waiting.get(source)
        return [each for claim in list(waiting) for each in self._look(claim)] if waiting else ()

    def decide(self) -> Iterator[Dated]:
        """The run is over: decide all."""
        for claim in list(self._awaits):
            claim.end()
            yield from self._look(claim)

    def _look(self, claim: Claim) -> Iterator[Dated]:
        found = claim.check(claim)
        if isinstance(found, frozenset):
            self._park(claim, found)
            return
        if claim in self._awaits:
            self._park(claim, frozenset())
        yield from ((claim.t_s, each) for each in found)

    def _park(self, claim: Claim, sources: frozenset[str]) -> None:
        """Keep a claim under these sources, and under no others."""
        before = self._awaits.pop(claim, frozenset())
        for source in before - sources:
            del self._waiting[source][claim]
        for source in sources - before:
            self._waiting.setdefault(source, {})[claim] = None
        if sources:
            self._awaits[claim] = sources
