"""How soon mutants are caught, guided against uniform. A shell.

Rule 1: both ways begin with the same seeds, in the same mutated copy of the source. Each ends with the first
        seed that surprises there and not in our own source, or gives up. All CPU time until then counts.
Rule 2: each trial begins with other seeds. Figures are medians; a trial that catches nothing is worse than
        any that does.
Rule 3: guided and uniform trials alternate. The CPU time of the same work doubles on a busy machine, and then
        it does for both.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import Outcome, Surprise, play
from clew.mutants.mutant import Mutant
from clew.mutants.run import apply, by, is_catch, outcomes_in
from clew.mutants.worker import WALL_S_MAX

HARD_SEEDS = 10  # in the median of the uniform trials
TRIALS_APART = 10_000  # seeds between the first seeds of two trials, and the most that a trial plays


class Trial(Struct, frozen=True, kw_only=True):
    """The seeds from one first seed on, until one catches the mutant."""

    first_seed: int
    seed: int | None
    """The seed that caught it; None: none did."""
    branches: str
    """The strikes that caught it; empty: the seed's own faults did."""
    by: str | None
    seeds: int
    """How many seeds were played."""
    cpu_s: float


class Way(Struct, frozen=True, kw_only=True):
    """All trials of one way to search."""

    trials: tuple[Trial, ...]
    caught: int
    seeds_median: float | None
    """None: half of the trials or more caught nothing."""
    cpu_s_median: float | None


class Compared(Struct, frozen=True, kw_only=True):
    """One mutant, guided against uniform."""

    mutant: str
    rule: str
    guided: Way
    uniform: Way
    seeds_ratio: float | None
    """Uniform median over guided; without a uniform one a lower bound. None: there is no guided median."""
    cpu_ratio: float | None

    @property
    def is_hard(self) -> bool:
        """Whether uniform seeds need long. What the first seed catches cannot be caught much sooner."""
        return (
            median(math.inf if each.seed is None else each.seeds for each in self.uniform.trials)
            >= HARD_SEEDS
        )


class Comparison(Struct, frozen=True, kw_only=True):
    """What `clew mutants --guided --json` prints."""

    mutants: tuple[Compared, ...]
    seeds_ratio_median: float | None
    cpu_ratio_median: float | None
    seeds_ratio_median_hard: float | None
    """The same for mutants for which half of the uniform trials or more need `HARD_SEEDS`, or give up."""
    cpu_ratio_median_hard: float | None


def compare(mutant: Mutant, trials: int, cpu_s_max: float) -> Compared:
    """Search for the mutant both ways; a trial gives up after this CPU time.

    Raises:
        UsageError: the source does not contain the piece to replace, or contains it twice.
    """
    firsts = [1 + TRIALS_APART * trial for trial in range(trials)]
    with TemporaryDirectory(prefix="clew-mutant-") as name:
        apply(mutant, Path(name))
        pairs = [
            [_trial(mutant, Path(name), first, cpu_s_max, guided=guided) for guided in (True, False)]
            for first in firsts
        ]
    guided, uniform = (_way(trials) for trials in zip(*pairs, strict=True))
    return Compared(
        mutant=mutant.name,
        rule=mutant.rule,
        guided=guided,
        uniform=uniform,
        seeds_ratio=_ratio([each.seeds for each in uniform.trials], guided.seeds_median),
        cpu_ratio=_ratio([each.cpu_s for each in uniform.trials], guided.cpu_s_median),
    )


def summed_up(mutants: Sequence[Compared]) -> Comparison:
    """All mutants, and the medians of the ratios that there are."""
    hard = [each for each in mutants if each.is_hard]
    return Comparison(
        mutants=tuple(mutants),
        seeds_ratio_median=_median_of([each.seeds_ratio for each in mutants]),
        cpu_ratio_median=_median_of([each.cpu_ratio for each in mutants]),
        seeds_ratio_median_hard=_median_of([each.seeds_ratio for each in hard]),
        cpu_ratio_median_hard=_median_of([each.cpu_ratio for each in hard]),
    )


def _median_of(ratios: Sequence[float | None]) -> float | None:
    """The median; what no guided trial has caught is worse than all that are."""
    return _median([-math.inf if each is None else each for each in ratios]) if ratios else None


def _trial(mutant: Mutant, folder: Path, first: int, cpu_s_max: float, *, guided: bool) -> Trial:
    cpu_s, seeds = 0.0, 0
    for outcome in outcomes_in(folder, first, first + TRIALS_APART - 1, guided=guided):
        cpu_s, seeds = cpu_s + outcome.cpu_s, seeds + 1
        if is_catch(outcome, mutant) and _passes_unmutated(outcome):
            return Trial(
                first_seed=first,
                seed=outcome.seed,
                branches=outcome.branches,
                by=by(outcome),
                seeds=seeds,
                cpu_s=cpu_s,
            )
        if cpu_s >= cpu_s_max:
            break
    return Trial(first_seed=first, seed=None, branches="", by=None, seeds=seeds, cpu_s=cpu_s)


def _passes_unmutated(outcome: Outcome) -> bool:
    episode = drawn_episode(outcome.seed, Path(), "", wall_s_max=WALL_S_MAX)
    return play(replace(episode, branches=outcome.branches)).surprise is Surprise.NONE


def _way(trials: Sequence[Trial]) -> Way:
    return Way(
        trials=tuple(trials),
        caught=sum(each.seed is not None for each in trials),
        seeds_median=_median([each.seeds if each.seed is not None else math.inf for each in trials]),
        cpu_s_median=_median([each.cpu_s if each.seed is not None else math.inf for each in trials]),
    )


def _median(figures: Sequence[float]) -> float | None:
    middle = median(figures)
    return None if math.isinf(middle) else middle


def _ratio(uniform: Sequence[float], guided: float | None) -> float | None:
    """A uniform trial that gave up counts with what it spent: it would have taken more."""
    return None if guided is None else median(uniform) / guided
