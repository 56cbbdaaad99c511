"""Two runs, aligned by switching step, and what came of them."""

import json
from pathlib import Path

import pytest

from clew.api.compare import compare
from clew.api.run import open_run
from protocol.errors import UsageError
from tests.support.campaigns import clew
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


def test_what_came_of_both_runs_stands_side_by_side(runs: Runs) -> None:
    calm, killed = open_run(runs.of("grove")), open_run(runs.of("grove", faults="leader-killed"))
    assert calm.verdict is not None
    assert killed.verdict is not None
    came = {(each.measure, each.robot): each for each in compare(calm, killed).outcomes}
    assert (came["robots_arrived", None].a, came["robots_arrived", None].b) == (5, 4)
    assert came["sim_s", None].difference == killed.verdict.sim_s - calm.verdict.sim_s
    death = killed.verdict.deaths[0]
    assert death.recovered_s is not None
    healed = came["healed_s", 1]
    assert (healed.a, healed.b, healed.difference) == (None, death.recovered_s - death.cause_s, None)
    assert ("moving_clearance_m_min", None) not in came, "nothing moves in the grove"
    lossy = compare(calm, open_run(runs.of("grove", faults="loss-50"))).outcomes
    lost = next(each for each in lossy if each.measure == "lost_to_faults")
    assert lost.a == 0
    assert lost.b is not None
    assert lost.b > 1000


def test_nothing_came_yet_of_a_run_without_a_verdict(runs: Runs, tmp_path: Path) -> None:
    cut = runs.copy(tmp_path / "cut", "grove")
    (cut / "verdict.json").unlink()
    assert compare(open_run(runs.of("grove")), open_run(cut)).outcomes == ()


def test_the_verb_compares_two_runs(runs: Runs) -> None:
    a, b = str(runs.of("grove")), str(runs.of("grove", faults="leader-killed"))
    done = clew("compare", a, b)
    assert done.exit_code == 0
    cells = [[cell.strip() for cell in line.split("│")[1:-1]] for line in done.stdout.splitlines()]
    assert ["robots arrived", "5", "4", "-1"] in cells
    assert ["promises broken", "0", "0", "+0"] in cells
    assert any(row[:2] == ["r1: death healed after [s]", "-"] for row in cells if row)
    assert f"A: {a}: OK: every living robot has arrived; 5 of 5" in done.stdout
    assert "started differently: faults; the first difference is in step" in done.stdout
    told = json.loads(clew("compare", a, b, "--json").stdout)
    assert told["asked"] == ["faults"]
    assert told["outcomes"][0] == {"measure": "robots_arrived", "robot": None, "a": 5, "b": 4}
    assert told["first"]["step"] > 0


def test_runs_have_no_pairs_of_episodes_to_show(runs: Runs) -> None:
    a = str(runs.of("grove"))
    done = clew("compare", a, a, "--each")
    assert done.exit_code == 2
    assert "--each is for two campaigns, and A and B are runs" in done.stderr


def test_a_run_and_something_else_cannot_be_compared(runs: Runs, tmp_path: Path) -> None:
    run, other = str(runs.of("grove")), str(tmp_path)
    refusal = f"Error: {other}: is no run, and {run} is one; compare two runs, or two campaigns\n"
    for pair in ((run, other), (other, run)):
        done = clew("compare", *pair)
        assert (done.exit_code, done.stderr) == (2, refusal)
    assert clew("compare", other, other).stderr == f"Error: {other}: is neither a run nor a campaign\n"
    for pair in ((run, run + "x"), (run + "x", other)):
        assert clew("compare", *pair).stderr == f"Error: {run}x: there is no such run or campaign\n"


def test_of_a_run_without_a_verdict_no_empty_table_is_drawn(runs: Runs, tmp_path: Path) -> None:
    log = tmp_path / "events.jsonl"
    log.write_bytes((runs.of("grove") / log.name).read_bytes())
    done = clew("compare", str(tmp_path), str(runs.of("grove")))
    assert done.exit_code == 0
    assert done.stdout.startswith(f"A: {tmp_path}: no verdict yet\n")


def test_a_folder_is_no_run_to_compare(runs: Runs) -> None:
    run = open_run(runs.of("grove"))
    with pytest.raises(UsageError, match=r"compare: must be two runs, .* got 'runs/x'"):
        compare(run, "runs/x")  # type: ignore[arg-type] # as in a notebook
