"""Two runs, aligned by switching step."""

import pytest

from clew.api.compare import compare
from clew.api.run import open_run
from protocol.errors import UsageError
from tests.support.runs import Runs


def test_a_run_is_the_same_as_itself(runs: Runs) -> None:
    run = open_run(runs.of("grove"))
    both = compare(run, run)
    assert (both.asked, both.first) == ((), None)
    assert str(both) == f"all {len(run.steps)} switching steps are the same"


def test_runs_with_other_seeds_differ_in_a_step_and_are_aligned(runs: Runs) -> None:
    one, other = open_run(runs.of("grove")), open_run(runs.of("grove", seed=2))
    both = compare(one, other)
    assert both.asked == ("seed",)
    assert both.first is not None
    assert both.first.number == 1
    assert "length_m" in both.first.apart
    assert compare(one, other, within=0.5).steps[0].same
    assert [pair.number for pair in both.steps] == sorted(pair.number for pair in both.steps)


def test_a_step_that_one_run_lacks_stands_alone(runs: Runs) -> None:
    one, other = open_run(runs.of("grove")), open_run(runs.of("grove", faults="leader-killed"))
    both = compare(one, other, within=1e9)
    alone = [pair for pair in both.steps if pair.a is None or pair.b is None]
    assert len(one.steps) != len(other.steps)
    assert alone
    assert str(compare(one, other)).startswith("started differently: faults; the first difference is in step")


def test_a_folder_is_no_run_to_compare(runs: Runs) -> None:
    run = open_run(runs.of("grove"))
    with pytest.raises(UsageError, match=r"compare: must be two runs, .* got 'runs/x'"):
        compare(run, "runs/x")  # type: ignore[arg-type] # as in a notebook
