from collections.abc import Iterator
from pathlib import Path

import pytest

from clew.campaign.episode import Outcome, Surprise
from clew.mutants import guided
from clew.mutants.guided import compare, summed_up
from clew.mutants.mutant import mutant

BROKEN = mutant("broken", "a rule", "file.py", "before", "after", breaks=("F1",))
CPU_S = 2.0  # of each seed
GUIDED, UNIFORM = True, False
EACH = {GUIDED: 3, UNIFORM: 40}
"""After how many seeds a trial catches the mutant."""


def outcome(seed: int, *, caught: bool) -> Outcome:
    return Outcome(
        key=str(seed),
        scene="",
        family="",
        seed=seed,
        robots=3,
        robots_left_out=0,
        ok=not caught,
        ending="",
        reason="",
        surprise=Surprise.VIOLATION if caught else Surprise.NONE,
        violations_by_invariant={"F1": int(caught)},
        wall_s=0.0,
        cpu_s=CPU_S,
        replay="",
    )


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each trial was guided, in order; none plays anything."""
    trials: list[bool] = []

    def outcomes_in(_: Path, first: int, last: int, *, guided: bool) -> Iterator[Outcome]:
        trials.append(guided)
        for seed in range(first, last + 1):
            yield outcome(seed, caught=seed == first + EACH[guided] - 1)

    monkeypatch.setattr(guided, "apply", lambda _mutant, _folder: None)
    monkeypatch.setattr(guided, "outcomes_in", outcomes_in)
    monkeypatch.setattr(guided, "_passes_unmutated", lambda _: True)
    return trials


def test_guided_and_uniform_trials_alternate(asked: list[bool]) -> None:
    compare(BROKEN, 2, 1e3)
    assert asked == [GUIDED, UNIFORM] * 2


@pytest.mark.usefixtures("asked")
def test_the_ratio_is_of_medians_and_at_least_that_of_what_uniform_trials_spent_before_they_gave_up() -> None:
    compared = compare(BROKEN, 3, 1e3)
    assert compared.cpu_ratio == pytest.approx(40 / 3)
    gave_up = compare(BROKEN, 3, 20 * CPU_S)
    assert gave_up.uniform.cpu_s_median is None
    assert gave_up.cpu_ratio == pytest.approx(20 / 3)
    assert compare(BROKEN, 3, CPU_S).cpu_ratio is None


@pytest.mark.usefixtures("asked")
def test_mutants_that_uniform_seeds_catch_early_are_not_in_the_median_of_the_hard_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hard = compare(BROKEN, 1, 1e3)
    monkeypatch.setitem(EACH, UNIFORM, 3)
    easy = compare(BROKEN, 1, 1e3)
    comparison = summed_up([hard, easy, easy])
    assert comparison.cpu_ratio_median == pytest.approx(1.0)
    assert comparison.cpu_ratio_median_hard == pytest.approx(40 / 3)
    assert summed_up([easy]).cpu_ratio_median_hard is None


@pytest.mark.usefixtures("asked")
def test_a_mutant_is_hard_where_uniform_trials_give_up_however_early() -> None:
    assert compare(BROKEN, 3, 4 * CPU_S).is_hard
