"""Two campaigns against each other: what changes where B plays the scenes and seeds that A plays.

Rule 1: an episode of A is paired with that of B of the same family, scene and seed. The others are counted.
Rule 2: shares are of all pairs, the other measures of the pairs in which both fleets arrived: a fleet that
        gives up early is not quick.
Rule 3: seeds of one scene are no independent evidence. So each scene counts once, with the mean of its pairs;
        only where there is one scene, each seed counts.
Rule 4: differences have confidence intervals of 95 %: for means by Student's t, for shares by Agresti and Min
        (Statistics in Medicine 24, 2005), who add two pairs, so that n equal pairs do not prove equality.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict
from scipy.special import ndtri, stdtrit

from clew.campaign.episode import Outcome
from protocol.errors import UsageError

UPPER = 0.975  # both tails of 95 %
PAIRS_ADDED = 2.0  # rule 4: together they differ by 0, and their squared differences add up to 1

Pair = tuple[Outcome, Outcome]
Place = tuple[str, str, int]


class Compared(Struct, frozen=True, kw_only=True):
    """One measure; docs/campaign.md explains each field."""

    measure: str
    pairs: int
    counted: int
    a: float | None = None
    b: float | None = None
    difference: float | None = None
    low: float | None = None
    high: float | None = None


class Paired(Struct, frozen=True, kw_only=True):
    """Two episodes of the same family, scene and seed: their measures by name."""

    family: str
    scene: str
    seed: int
    a: dict[str, float | None]
    b: dict[str, float | None]


class Comparison(Struct, frozen=True, kw_only=True):
    """Two campaigns; docs/campaign.md explains each field."""

    asked: dict[str, tuple[Any, Any]]
    pairs: int
    scenes: int
    only_a: int
    only_b: int
    measures: tuple[Compared, ...]
    each: tuple[Paired, ...]
    """First those in which B did not arrive, then those in which B took longer than A by most."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of an episode."""

    name: str
    of: Callable[[Outcome], float | None]
    is_share: bool = False


MEASURES = (
    Measure("no_promise_broken", lambda each: float(each.ended and each.violations == 0), is_share=True),
    Measure("arrived", lambda each: float(each.ok), is_share=True),
    Measure("sim_s", lambda each: each.sim_s),
    Measure("path_m", lambda each: each.path_m),
    Measure("switching_steps", lambda each: float(each.switching_steps)),
    Measure("events_per_m", lambda each: each.events_per_m),
    Measure("clearance_margin_m", lambda each: each.clearance_margin_m),
)


class Asked(Struct, frozen=True, kw_only=True):
    """What was asked of a campaign and may be asked otherwise of another, as in `campaign.json`."""

    law: str | None = None
    robots: int | None = None
    deployment: str | None = None
    time_s_max: float | None = None
    tight: float | None = None
    faults: str | None = None
    guided: bool = False
    source_hash: str | None = None


def compare(a: Iterable[Outcome], b: Iterable[Outcome], asked: tuple[Asked, Asked]) -> Comparison:
    """B against A.

    Raises:
        UsageError: they have no episode in common, or one has two of the same family, scene and seed.
    """
    ours, theirs = _by_place(a, "A"), _by_place(b, "B")
    pairs = [(ours[place], theirs[place]) for place in sorted(ours.keys() & theirs.keys())]
    if not pairs:
        raise UsageError(
            "the campaigns have no family, scene and seed in common: there is nothing to compare"
        )
    ours_asked, theirs_asked = map(asdict, asked)
    return Comparison(
        asked={
            name: (value, theirs_asked[name])
            for name, value in ours_asked.items()
            if value != theirs_asked[name]
        },
        pairs=len(pairs),
        scenes=len({_scene(pair) for pair in pairs}),
        only_a=len(ours) - len(pairs),
        only_b=len(theirs) - len(pairs),
        measures=tuple(_compared(measure, pairs) for measure in MEASURES),
        each=tuple(map(_paired, sorted(pairs, key=_longer_s, reverse=True))),
    )


def _longer_s(pair: Pair) -> tuple[bool, float]:
    """How much worse B was."""
    a, b = pair
    return not b.ok, b.sim_s - a.sim_s


def _paired(pair: Pair) -> Paired:
    a, b = ({measure.name: measure.of(each) for measure in MEASURES} for each in pair)
    return Paired(family=pair[0].family, scene=pair[0].scene, seed=pair[0].seed, a=a, b=b)


def _by_place(outcomes: Iterable[Outcome], which: str) -> dict[Place, Outcome]:
    found: dict[Place, Outcome] = {}
    for each in outcomes:
        place = (each.family, each.scene, each.seed)
        if place in found:
            raise UsageError(f"{which} has two episodes of {each.family}/{each.scene}, seed {each.seed}")
        found[place] = each
    return found


def _compared(measure: Measure, pairs: Sequence[Pair]) -> Compared:
    by_scene = len({_scene(pair) for pair in pairs}) > 1  # rule 3
    units: dict[object, list[tuple[float, float]]] = {}
    for pair in pairs:
        a, b = map(measure.of, pair)
        if a is not None and b is not None and (measure.is_share or all(each.ok for each in pair)):
            units.setdefault(_scene(pair) if by_scene else pair[0].seed, []).append((a, b))
    count = sum(map(len, units.values()))
    if not units:
        return Compared(measure=measure.name, pairs=count, counted=0)
    a_mean, b_mean = np.array([np.mean(values, axis=0) for values in units.values()]).T
    apart = b_mean - a_mean
    low, high = (share_interval if measure.is_share else mean_interval)(apart)
    return Compared(
        measure=measure.name,
        pairs=count,
        counted=len(units),
        a=float(a_mean.mean()),
        b=float(b_mean.mean()),
        difference=float(apart.mean()),
        low=low,
        high=high,
    )


def mean_interval(apart: np.ndarray) -> tuple[float | None, float | None]:
    """The interval of a mean difference; None: one difference has none."""
    if len(apart) < 2:
        return None, None
    half = float(stdtrit(len(apart) - 1, UPPER)) * float(np.std(apart, ddof=1)) / math.sqrt(len(apart))
    return float(apart.mean()) - half, float(apart.mean()) + half


def share_interval(apart: np.ndarray) -> tuple[float, float]:
    """The interval of a difference of shares, from the differences of each unit, -1 to 1."""
    count = len(apart) + PAIRS_ADDED
    middle = float(apart.sum()) / count
    spread = (float(np.square(apart).sum()) + 1.0) / count - middle**2
    half = float(ndtri(UPPER)) * math.sqrt(spread / count)
    return max(middle - half, -1.0), min(middle + half, 1.0)


def _scene(pair: Pair) -> tuple[str, str]:
    return pair[0].family, pair[0].scene
