"""The second judge sees what a world that judges leniently lets pass."""

import json
from pathlib import Path

import pytest

from clew.mutants.list import MUTANTS
from clew.mutants.run import run_mutant
from tests.support.campaigns import clew
from tests.support.judges import differences
from tests.support.long import long
from tests.support.runs import Runs


@pytest.mark.parametrize("name", ["neighbours-uncompared", *long(["lenient-monitor"])])
def test_a_campaign_catches_a_monitor_that_is_lenient_by_the_second_judge(name: str) -> None:
    [mutant] = [each for each in MUTANTS if each.name == name]
    caught = run_mutant(mutant)
    assert (caught.by, caught.seeds <= 3) == ("judges", True)


def test_a_death_that_nobody_asked_for_and_that_the_verdict_forgives_is_found(
    tmp_path: Path, runs: Runs
) -> None:
    run = runs.copy(tmp_path / "run", "grove", faults="middle-killed")
    assert differences(run) == []
    events = run / "events.jsonl"
    header, *lines = events.read_text().splitlines(keepends=True)
    kept = [each for each in lines if '"fault.injected"' not in each]
    events.write_text(json.dumps(json.loads(header) | {"faults": None}) + "\n" + "".join(kept))
    [said] = differences(run)
    assert "ok, by true poses robot 3 stands in no chain behind the robot at the goal, and nobody" in said


def test_the_verb_exits_with_1_where_the_verdict_says_something_better(tmp_path: Path, runs: Runs) -> None:
    run = runs.copy(tmp_path / "run", "grove")
    assert clew("judge", run).exit_code == 0
    verdict = run / "verdict.json"
    verdict.write_text(json.dumps(json.loads(verdict.read_text()) | {"separation_m_min": 0.2}))
    said = clew("judge", run)
    assert said.exit_code == 1
    assert said.stdout.endswith("FAILED: promises kept, arrived; the verdict differs\n")
    assert "the verdict differs: separation_m_min is 0.2, by true poses robot" in said.stdout
