"""The result of a benchmark, the same for all: machine, versions, figures with spread and baseline. Pure.

Rule 1: a repeat is one whole run of the benchmark. Percentiles over what a run measured (its plans, its hops)
        are taken within the run; the spread is over the repeats.
Rule 2: a baseline is measured in the same run, right beside. Its ratio is taken repeat by repeat, so that
        other load on the machine counts for both.
Rule 3: a benchmark that can fail fails by the aims of its figures, and by nothing else: so the exit code, the
        table and the page say the same. Of the others, a missed aim is a figure like any other.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from msgspec import Struct

from clew.percentiles import percentile


class Spread(Struct, frozen=True, kw_only=True):
    """What all repeats measured; quartiles are nearest rank.

    None is infinite: a time that never came, or another figure that was not measured.
    """

    repeats: int
    least: float | None
    quartile: float | None
    """The first: a quarter of the repeats have at most this."""
    median: float | None
    quartile_3: float | None
    most: float | None


class Baseline(Struct, frozen=True, kw_only=True):
    """What a figure is compared with, measured in the same run."""

    name: str
    measured: Spread
    ratio: Spread
    """The figure divided by its baseline, repeat by repeat."""


class Aim(Struct, frozen=True, kw_only=True):
    """What a figure is to reach: at most or at least so much; without either, to come at all."""

    of: str = ""
    """The baseline whose ratio has the aim; empty: the figure itself."""
    at_most: float | None = None
    at_least: float | None = None
    each: bool = False
    """Whether every repeat is to reach it, and not only the median."""

    def is_met(self, asked: Spread) -> bool:
        """Whether these repeats reach it."""
        return all(
            value is not None
            and (self.at_most is None or value <= self.at_most)
            and (self.at_least is None or value >= self.at_least)
            for value in ((asked.least, asked.most) if self.each else (asked.median,))
        )


class Figure(Struct, frozen=True, kw_only=True):
    """One figure of a benchmark."""

    name: str
    unit: str
    measured: Spread
    baselines: tuple[Baseline, ...] = ()
    aim: Aim | None = None
    met: bool | None = None
    """Whether the aim is reached; None: there is none."""


class Machine(Struct, frozen=True, kw_only=True):
    """Where a benchmark ran."""

    cpu: str
    """The processor's model."""
    cores: int
    """Those that the benchmark may use."""
    memory_mb: int
    kernel: str
    load: float
    """Load average of the last minute, when the benchmark began: all work, also that of others."""


class Result(Struct, frozen=True, kw_only=True):
    """What a benchmark prints as JSON."""

    benchmark: str
    command: str
    """The command line that repeats it."""
    about: str
    """What is measured and how, for people."""
    at: str
    """The day (UTC)."""
    machine: Machine
    versions: Mapping[str, str]
    """Of Python, of Clew (its commit) and of the packages that do the work."""
    figures: tuple[Figure, ...]
    details: Any = None
    """What the benchmark has beside its figures."""


def spread(values: Sequence[float | None]) -> Spread:
    """The spread of what the repeats measured, of which there is at least one."""
    known = list(map(_or_never, values))
    least, quartile, median, quartile_3, most = (
        value if math.isfinite(value) else None
        for value in (percentile(known, percent) for percent in (0, 25, 50, 75, 100))
    )
    return Spread(
        repeats=len(values),
        least=least,
        quartile=quartile,
        median=median,
        quartile_3=quartile_3,
        most=most,
    )


def figure(
    name: str,
    unit: str,
    values: Sequence[float | None],
    *,
    baselines: Mapping[str, Sequence[float | None]] | None = None,
    aim: Aim | None = None,
) -> Figure:
    """A figure from what its repeats measured.

    Args:
        name: what it is, with its setting: `5 robots, no faults`.
        unit: its unit, as people write it.
        values: one for each repeat; None or infinite: it never came.
        baselines: by name what was measured beside each repeat.
        aim: what to reach.
    """
    compared = tuple(
        Baseline(name=each, measured=spread(beside), ratio=spread(_ratios(values, beside)))
        for each, beside in (baselines or {}).items()
    )
    measured, met = spread(values), None
    if aim is not None:
        asked = {"": measured, **{each.name: each.ratio for each in compared}}
        met = aim.is_met(asked[aim.of])
    return Figure(name=name, unit=unit, measured=measured, baselines=compared, aim=aim, met=met)


def all_met(figures: Iterable[Figure]) -> bool:
    """Whether no aim is missed."""
    return all(each.met is not False for each in figures)


def _or_never(value: float | None) -> float:
    return math.inf if value is None else value


def _ratios(values: Sequence[float | None], beside: Sequence[float | None]) -> list[float]:
    """Rule 2; what never came is infinitely longer than any baseline."""
    pairs = zip(map(_or_never, values), map(_or_never, beside), strict=True)
    return [value / base if base and math.isfinite(value) else math.inf for value, base in pairs]
