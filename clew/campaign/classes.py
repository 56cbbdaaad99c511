"""The figures of a campaign with faults: by class of fault, and the coverage counters.

Rule 1: an episode counts in every class that its seed has drawn.
Rule 2: if none of n episodes failed, the failure rate is at most 3 / n with 95 % confidence (at most 1).
"""

from collections import Counter
from collections.abc import Mapping, Sequence

from msgspec import Struct
from rich.table import Table

from clew.campaign.episode import Outcome, Surprise
from clew.coverage.situations import Situation
from clew.swarm.classes import FaultClass
from clew.swarm.swarm import Mode

ALL = "all"
BOUND = 3.0  # -ln 0.05


class ClassFigures(Struct, frozen=True, kw_only=True):
    """The figures of all episodes with one class of faults; docs/campaign.md explains each field."""

    episodes: int
    liveness_episodes: int
    violations: int
    liveness_failures: int
    crashed: int
    stopped: int
    safety_bound: float | None
    """Upper bound on the share of episodes that break an invariant or crash; None where one did."""
    liveness_bound: float | None
    cpu_s_mean: float


def by_class(outcomes: Sequence[Outcome]) -> dict[str, ClassFigures]:
    """The figures by class of fault, and of all; empty where no classes were drawn."""
    if not any(outcome.classes for outcome in outcomes):
        return {}
    classes = {
        each.value: [outcome for outcome in outcomes if each in outcome.classes] for each in FaultClass
    }
    return {name: _figures(some) for name, some in {**classes, ALL: list(outcomes)}.items() if some}


def _figures(outcomes: Sequence[Outcome]) -> ClassFigures:
    count = Counter(outcome.surprise for outcome in outcomes)
    ended = [outcome for outcome in outcomes if outcome.surprise is not Surprise.STOPPED]
    lively = sum(outcome.mode == Mode.LIVENESS for outcome in ended)
    crashed, broken = count[Surprise.CRASHED], count[Surprise.VIOLATION]
    return ClassFigures(
        episodes=len(outcomes),
        liveness_episodes=lively,
        violations=broken,
        liveness_failures=count[Surprise.LIVENESS],
        crashed=crashed,
        stopped=count[Surprise.STOPPED],
        safety_bound=None if broken or crashed or not ended else _bound(len(ended)),
        liveness_bound=None if count[Surprise.LIVENESS] or crashed or not lively else _bound(lively),
        cpu_s_mean=sum(outcome.cpu_s for outcome in outcomes) / len(outcomes),
    )


def _bound(episodes: int) -> float:
    return min(BOUND / episodes, 1.0)


def sum_of_coverage(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """The coverage counters of all episodes together."""
    total: Counter[str] = Counter()
    for outcome in outcomes:
        total.update(outcome.coverage)
    return dict(sorted(total.items()))


def class_table(classes: Mapping[str, ClassFigures]) -> Table:
    """A row for each class, then a row for all."""
    counts = ("episodes", "liveness", "violations", "not live", "crashed")
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
            str(figures.liveness_failures),
            str(figures.crashed),
            _share(figures.safety_bound),
            _share(figures.liveness_bound),
            f"{figures.cpu_s_mean:.2f}",
        )
    return drawn


def coverage_table(counts: Mapping[str, int]) -> Table:
    """A row for each coverage counter."""
    drawn = Table("coverage", "count")
    drawn.columns[1].justify = "right"
    for each in Situation:
        drawn.add_row(each.value, str(counts.get(each.value, 0)))
    return drawn


def _share(bound: float | None) -> str:
    return "-" if bound is None else f"{bound:.4f}"
