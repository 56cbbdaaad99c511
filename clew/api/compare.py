"""Two runs side by side, aligned by switching step. Pure.

Rule 1: steps of one number are compared by what the leader decided, as `clew log diff --by step` does: from
        where to where, by which law. Times, and which robots were in sight, are left out.
Rule 2: a step that was planned again is aligned with the other run's plan of the same count.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import msgspec

from clew.api.outcomes import Outcome, outcomes
from clew.api.run import Run
from clew.log.diff import NO_DIFFERENCE_OF_STEPS, apart, headers_apart
from clew.story.steps import Step
from protocol.errors import UsageError


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One switching step in both runs."""

    number: int
    a: Step | None
    """None: this run has no such step."""
    b: Step | None
    apart: tuple[str, ...]
    """The fields of the plan that differ, as `target.x_m`; empty: the same decision, or one run lacks it."""

    @property
    def same(self) -> bool:
        """Whether both runs have the step, and decided the same."""
        return self.a is not None and self.b is not None and not self.apart


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Two runs, step by step, and what came of them."""

    asked: tuple[str, ...]
    """What differs in what was asked for, as `seed`."""
    steps: tuple[Pair, ...]
    outcomes: tuple[Outcome, ...]
    """What came of both, figure by figure; empty until both have a verdict."""

    @property
    def first(self) -> Pair | None:
        """The first step that differs; None: all are the same."""
        return next((pair for pair in self.steps if not pair.same), None)

    def __str__(self) -> str:
        asked = f"started differently: {', '.join(self.asked)}; " if self.asked else ""
        if self.first is None:
            return f"{asked}all {len(self.steps)} switching steps are the same"
        return f"{asked}the first difference is in step {self.first.number}: {_why(self.first)}"


def compare(a: Run, b: Run, *, within: float = 0.0) -> Comparison:
    """Compare two runs; `within`: how much numbers may differ.

    Raises:
        UsageError: one of them is no run.
    """
    for run in (a, b):
        if not isinstance(run, Run):
            raise UsageError(f"compare: must be two runs, as clew.open gives them, got {run!r}")
    pairs = sorted(_pairs(a.steps, b.steps, within=within), key=lambda pair: pair.number)
    asked, came = headers_apart(a.header, b.header), outcomes(a.verdict, b.verdict)
    return Comparison(asked=asked, steps=tuple(pairs), outcomes=came)


def _pairs(ours: Iterable[Step], theirs: Iterable[Step], *, within: float) -> Iterator[Pair]:
    one, other = dict(_counted(ours)), dict(_counted(theirs))
    for key in {**one, **other}:
        here, there = one.get(key), other.get(key)
        differs = () if here is None or there is None else tuple(_apart(here, there, within=within))
        yield Pair(number=key[0], a=here, b=there, apart=differs)


def _counted(steps: Iterable[Step]) -> Iterator[tuple[tuple[int, int], Step]]:
    """Rule 2."""
    counts: Counter[int] = Counter()
    for step in steps:
        counts[step.number] += 1
        yield (step.number, counts[step.number]), step


def _apart(one: Step, other: Step, *, within: float) -> Iterator[str]:
    """Rule 1."""
    plans = (
        {name: value for name, value in fields.items() if name not in NO_DIFFERENCE_OF_STEPS}
        for fields in map(msgspec.to_builtins, (one.plan, other.plan))
    )
    return apart(*plans, within=within)


def _why(pair: Pair) -> str:
    if pair.a is None or pair.b is None:
        return "one run has no such step"
    return ", ".join(pair.apart)
