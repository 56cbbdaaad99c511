"""The figures of a campaign with faults: by class of fault, and what has happened at times.

Rule 1: an episode counts in every class that its seed has drawn.
Rule 2: where none of n episodes failed, at most 3 / n do, with 95 % confidence; that is the bound, or 1.
"""

from collections import Counter
from collections.abc import Mapping, Sequence

from msgspec import Struct
from rich.table import Table

from clew.campaign.coverage_names import Sometimes
from clew.campaign.episode import Outcome, Surprise
from clew.swarm.classes import FaultClass
from clew.swarm.swarm import Mode

ALL = "all"
BOUND = 3.0  # -ln 0.05


class ClassFigures(Struct, frozen=True, kw_only=True):
    """What the episodes with a class of faults add up to; docs/campaign.md says what each field means."""

    episodes: int
    liveness_episodes: int
    violations: int
    unlively: int
    crashed: int
    safety_bound: float | None
    """Of episodes that break an invariant or crash; None where one did."""
    liveness_bound: float | None
    cpu_s_mean: float


def by_class(outcomes: Sequence[Outcome]) -> dict[str, ClassFigures]:
    """The figures by class of fault, and of all; nothing where no classes were drawn."""
    if not any(outcome.classes for outcome in outcomes):
        return {}
    classes = {
        each.value: [outcome for outcome in outcomes if each in outcome.classes] for each in FaultClass
    }
    return {name: _figures(some) for name, some in {**classes, ALL: list(outcomes)}.items() if some}


def _figures(outcomes: Sequence[Outcome]) -> ClassFigures:
    count = Counter(outcome.surprise for outcome in outcomes)
    lively = sum(outcome.mode == Mode.LIVENESS for outcome in outcomes)
    crashed, broken = count[Surprise.CRASHED], count[Surprise.VIOLATION]
    return ClassFigures(
        episodes=len(outcomes),
        liveness_episodes=lively,
        violations=broken,
        unlively=count[Surprise.UNLIVELY],
        crashed=crashed,
        safety_bound=None if broken or crashed else _bound(len(outcomes)),
        liveness_bound=None if count[Surprise.UNLIVELY] or crashed or not lively else _bound(lively),
        cpu_s_mean=sum(outcome.cpu_s for outcome in outcomes) / len(outcomes),
    )


def _bound(episodes: int) -> float:
    return min(BOUND / episodes, 1.0)


def sum_of_sometimes(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How often each thing has happened, in all episodes together."""
    total: Counter[str] = Counter()
    for outcome in outcomes:
        total.update(outcome.sometimes)
    return dict(sorted(total.items()))


def class_table(classes: Mapping[str, ClassFigures]) -> Table:
    """A row for each class, and the last for all."""
    counts = ("episodes", "liveness", "violations", "unlively", "crashed")
    drawn = Table("fault", *counts, "3/N", "3/N live", "cpu, s")
    for column in drawn.columns[1:]:
        column.justify = "right"
    for name, figures in classes.items():
        if name == ALL:
            drawn.add_section()
        drawn.add_row(
            name,
            str(figures.episodes),
            str(figures.liveness_episodes),
            str(figures.violations),
            str(figures.unlively),
            str(figures.crashed),
            _share(figures.safety_bound),
            _share(figures.liveness_bound),
            f"{figures.cpu_s_mean:.2f}",
        )
    return drawn


def sometimes_table(counts: Mapping[str, int]) -> Table:
    """How often each thing has happened that has to."""
    drawn = Table("sometimes", "count")
    drawn.columns[1].justify = "right"
    for each in Sometimes:
        drawn.add_row(each.value, str(counts.get(each.value, 0)))
    return drawn


def _share(bound: float | None) -> str:
    return "-" if bound is None else f"{bound:.4f}"
