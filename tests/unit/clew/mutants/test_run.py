from collections.abc import Iterator
from pathlib import Path

import pytest

from clew.campaign.episode import Outcome, Surprise
from clew.mutants.list import MUTANTS
from clew.mutants.mutant import Edit, Mutant
from clew.mutants.run import apply, is_catch, run_mutant
from protocol.errors import UsageError
from protocol.root import ROOT
from protocol.timeline.invariants import INVARIANTS
from tests.support.campaigns import outcome


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_each_mutant_applies_to_the_source_and_still_compiles(mutant: Mutant) -> None:
    for edit in mutant.edits:
        text = (ROOT / edit.file).read_text(encoding="utf-8")
        assert text.count(edit.before) == 1
        compile(text.replace(edit.before, edit.after), edit.file, "exec")


def test_there_are_at_least_fifteen_mutants_with_different_names() -> None:
    names = [mutant.name for mutant in MUTANTS]
    assert len(set(names)) == len(names) >= 15


def test_a_mutant_whose_source_no_longer_exists_is_an_error(tmp_path: Path) -> None:
    gone = Mutant("gone", "", (Edit("protocol/wire/link.py", "this was never written", ""),))
    with pytest.raises(UsageError, match="0 times, not once"):
        apply(gone, tmp_path)


def test_a_mutant_changes_the_copy_and_not_our_source(tmp_path: Path) -> None:
    file = "protocol/wire/link.py"
    ours = (ROOT / file).read_text(encoding="utf-8")
    apply(Mutant("named", "", (Edit(file, "class Link(", "class Mutated("),)), tmp_path)
    assert (ROOT / file).read_text(encoding="utf-8") == ours
    assert (tmp_path / file).read_text(encoding="utf-8") == ours.replace("class Link(", "class Mutated(")


def test_a_mutant_is_caught_and_an_unchanged_source_is_not() -> None:
    mutants = {mutant.name: mutant for mutant in MUTANTS}
    caught = run_mutant(mutants["drives-on"])  # its run ends as soon as it has broken F1
    assert caught.ok
    assert "F1" in str(caught.by)
    harmless = Mutant(
        "harmless", "", (Edit("protocol/wire/link.py", "class Link(", "class Link("),), seeds_max=1
    )
    assert not run_mutant(harmless).ok


@pytest.mark.parametrize("mutant", [each for each in MUTANTS if each.check], ids=lambda mutant: mutant.name)
def test_a_test_that_catches_a_mutant_exists(mutant: Mutant) -> None:
    file, test = mutant.check.split("::")
    assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8")


def test_a_mutant_that_no_swarm_shows_is_caught_by_its_test() -> None:
    caught = run_mutant(next(mutant for mutant in MUTANTS if mutant.name == "pieces-are-all"))
    assert (caught.by, caught.seed) == ("test", None)


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_each_mutant_says_what_a_catch_breaks_or_which_test_catches_it(mutant: Mutant) -> None:
    assert set(mutant.breaks) <= {*INVARIANTS, Surprise.LIVENESS, Surprise.JUDGES}
    assert bool(mutant.breaks) is not bool(mutant.check)


def test_only_a_surprise_by_what_a_mutant_breaks_is_a_catch() -> None:
    """`no-epsilon` was once caught by a separation, and another mutant by a rounding."""
    mutant = Mutant("", "", (), breaks=("S1", Surprise.LIVENESS))
    for broken, is_its in ({"S1": 1}, True), ({"S1": 1, "S2": 3}, True), ({"S1": 0, "S2": 3}, False):
        found = outcome(surprise=Surprise.VIOLATION, violations_by_invariant=broken)
        assert is_catch(found, mutant) is is_its
    assert {each for each in Surprise if is_catch(outcome(surprise=each), mutant)} == {Surprise.LIVENESS}
    mutant = Mutant("", "", (), breaks=(Surprise.NONE, Surprise.STOPPED))
    assert not any(is_catch(outcome(surprise=each), mutant) for each in Surprise)


@pytest.mark.parametrize(
    ("catches", "played"), [({7, 9}, [(7, 7)]), ({9}, [(7, 7), (1, 300)]), (set(), [(7, 7), (1, 300)])]
)
def test_the_seed_that_caught_a_mutant_before_is_played_first(
    monkeypatch: pytest.MonkeyPatch, catches: set[int], played: list[tuple[int, int]]
) -> None:
    parts = []

    def outcomes(_folder: Path, first: int, last: int) -> Iterator[Outcome]:
        parts.append((first, last))
        for seed in range(first, last + 1):
            yield outcome(seed=seed, surprise=Surprise.VIOLATION if seed in catches else Surprise.NONE)

    monkeypatch.setattr("clew.mutants.run.outcomes_in", outcomes)
    monkeypatch.setattr("clew.mutants.run.passes_unmutated", lambda _seed: True)
    harmless = Mutant(
        "harmless",
        "",
        (Edit("protocol/wire/link.py", "class Link(", "class Link("),),
        seed=7,
        breaks=(Surprise.VIOLATION,),
    )
    assert run_mutant(harmless).seed == min(catches, default=None)
    assert parts == played
