"""`--faults drawn`: the seed draws the faults, and the user has the scenario."""

import json
from pathlib import Path

import pytest

from clew.api.rehearsed import rehearse
from clew.swarm.plans import plan_for
from protocol.errors import UsageError
from protocol.faults.fit import check_fits
from protocol.faults.plan import Plan
from protocol.files.reading import read, understand
from tests.support.campaigns import clew, scene, told


@pytest.mark.parametrize("robots", [2, 3, 50])
def test_what_a_seed_draws_fits_a_fleet_of_any_size_and_each_seed_draws_its_own(robots: int) -> None:
    drawn = [plan_for("drawn", robots=robots, seed=seed) for seed in range(60)]
    for plan in drawn:
        check_fits(plan, robots=robots, source="drawn")
    assert len({plan.rules for plan in drawn}) == len(drawn)
    assert drawn == [plan_for("drawn", robots=robots, seed=seed) for seed in range(60)]


def test_a_robot_alone_has_no_faults_drawn() -> None:
    with pytest.raises(UsageError, match="faults drawn: need at least 2 robots, got 1"):
        plan_for("drawn", robots=1, seed=1)


def test_each_episode_has_faults_of_its_own_and_the_line_of_one_replays_it(tmp_path: Path) -> None:
    """Nobody has to arrive: in seed 13 nobody does, and that is no surprise."""
    asked = ("campaign", scene(tmp_path / "one.json"), "-n", "3", "--faults", "drawn", "--seeds", "1,2,13")
    assert clew(*asked, "--jobs", "1", "--out", tmp_path / "out").exit_code == 0
    episodes = told(tmp_path / "out")["episodes"]
    assert len({json.dumps(each["injected"]) for each in episodes}) == len(episodes)
    assert [each["robots_arrived"] for each in episodes] == [2, 3, 0]
    first = episodes[0]
    again = json.loads(clew(*first["replay"].split()[1:], "--json").stdout)
    assert (again["sim_s"], again["robots_arrived"]) == (first["sim_s"], first["robots_arrived"])


def test_the_folder_of_a_run_has_the_plan_that_was_drawn(tmp_path: Path) -> None:
    run = rehearse(scene(tmp_path / "one.json"), robots=2, seed=3, faults="drawn", out=tmp_path / "run")
    kept = understand(read(run.folder / "faults.toml", "faults.toml"), Plan, "faults.toml")
    assert kept.rules == plan_for("drawn", robots=2, seed=3).rules


@pytest.mark.parametrize("verb", ["rehearse", "campaign"])
def test_a_drawn_plan_is_among_the_names_that_a_refusal_lists(verb: str) -> None:
    said = clew(verb, "grove", "--faults", "draw")
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert said.stderr.rstrip().endswith("or a .toml file; did you mean 'drawn'?")
