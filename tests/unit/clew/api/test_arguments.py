"""What cannot be done as a Python user asks is refused in the words of Python, before anything is made."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clew

Call = Callable[..., object]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rehearsed(scenario: object = "grove", **asked: Any) -> object:  # noqa: ANN401 - anything that a user may write
    return clew.rehearse(scenario, **asked)  # type: ignore[arg-type] # as a user may write it


def launched(scenario: object = "grove", **asked: Any) -> object:  # noqa: ANN401 - anything that a user may write
    return clew.launch(scenario, **asked)  # type: ignore[arg-type] # as a user may write it


@pytest.mark.parametrize("call", [rehearsed, launched])
@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({"robots": 0}, r"grove: \$\.fleet\.robots: must be >= 1, got 0 \(robots = 0 instead of 5\)"),
        ({"robots": "3"}, "robots: must be an integer, got '3'"),
        ({"robots": 2.5}, r"robots: must be an integer, got 2\.5"),
        (
            {"time_s_max": 0},
            r"grove: \$\.time\.time_s_max: must be > 0\.0 s, got 0 \(time_s_max = 0 .*\)",
        ),
        ({"seed": -1}, r"clew: \$\.seed: must be >= 0, got -1"),
        ({"seed": 2**60}, r"clew: \$\.seed: must be <= 9007199254740991, got 1152921504606846976"),
        ({"robots": True}, "robots: must be an integer, got True"),
        ({"seed": "x"}, "seed: must be an integer, got 'x'"),
        ({"seed": 1.5}, r"seed: must be an integer, got 1\.5"),
        ({"law": "nope"}, r"grove: \$\.law\.law: must be one of .* \(law = 'nope' instead of 'certified'\)"),
        ({"law": print}, "law: must be a name; clew.register_law gives one to a function"),
        ({"deployment": "randm"}, r"grove: .*did you mean 'random'\? \(deployment = 'randm'\)"),
        ({"faults": "leader-kiled"}, r"unknown fault plan 'leader-kiled': .*did you mean 'leader-killed'\?"),
        ({"faults": Path("none.toml")}, r"none\.toml: cannot be read: No such file or directory"),
        (
            {"faults": [clew.kill(9)]},
            r"clew\.kill: \$\.target: must be a robot of the fleet, r1 to r5, got r9",
        ),
        (
            {"faults": "one-way", "robots": 3},
            r"one-way: \$\.rule\[0\]\.group\[1\]: must be a robot .*, got r4",
        ),
        ({"faults": [clew.drop(name="a"), clew.kill(1, name="a")]}, r"clew\.kill: \$\.name: .*, got a twice"),
        ({"faults": [3]}, r"faults: must be a plan, or a list of rules such as .*, got \[3\]"),
        ({"faults": None}, "faults: must be a plan, or a list of rules .*, got None"),
        ({"scenario": 3}, "scenario: must be a name, a file or a scenario, got 3"),
        ({"out": 3}, "out: must be a folder, got 3"),
        ({"out": ""}, "out: must be a folder, got ''"),
    ],
)
def test_arguments_that_no_fleet_can_have_are_refused(
    here: Path, call: Call, asked: dict[str, object], why: str
) -> None:
    with pytest.raises(clew.UsageError, match=f"^{why}$"):
        call(**asked)
    assert list(here.iterdir()) == []


@pytest.mark.parametrize("given", [3, None, ""])
def test_only_a_path_can_be_opened(given: Any) -> None:  # noqa: ANN401 - anything that a user may write
    with pytest.raises(clew.UsageError, match=r"^open: must be the folder of a run, or "):
        clew.open(given)


def test_a_stage_that_is_none_is_not_taken_for_live() -> None:
    with pytest.raises(clew.UsageError, match="stage: must be live or rehearsal, got 'rehearse'"):
        launched(stage="rehearse")


@pytest.mark.parametrize("stage", ["live", "rehearsal"])
@pytest.mark.parametrize("speed", [-1, 0, "fast", 1e9])
def test_a_speed_that_no_fleet_has_is_refused_on_both_stages(stage: str, speed: object) -> None:
    with pytest.raises(clew.UsageError, match=r"^speed: must be max or a number in \(0, 1000\], got "):
        launched(stage=stage, speed=speed)


def test_a_folder_that_is_not_empty_is_refused_without_a_word_of_options(here: Path) -> None:
    (here / "run").mkdir()
    (here / "run" / "file").touch()
    with pytest.raises(clew.UsageError, match=r"^run: is not empty; a run needs a new or an empty"):
        rehearsed(out="run")


def test_a_fault_that_is_no_rule_is_refused_by_a_fleet() -> None:
    fleet = clew.launch("grove", robots=2, stage="rehearsal")
    with pytest.raises(clew.UsageError, match=r"^inject: must be a rule, such as .*, got 'kill'$"):
        fleet.inject("kill")  # type: ignore[arg-type] # what a user may write


def test_a_scenario_may_be_a_path_numbers_those_of_numpy_and_faults_a_single_rule(here: Path) -> None:
    rehearsed(robots=1, out="first")
    path, rule = here / "first" / "scenario.toml", clew.drop(p=0.1)
    run = clew.rehearse(path, robots=np.int64(2), seed=np.int64(3), faults=rule, out="run")  # type: ignore[arg-type] # a list is the documented way
    assert (run.seed, run.scenario.fleet.robots) == (3, 2)
    assert {fault.fault for fault in run.faults} == {"drop"}


def test_a_fault_plan_is_given_by_its_name_or_its_file(here: Path) -> None:
    plan = here / "mine.toml"
    plan.write_text('name = "mine"\n[[rule]]\nfault = "kill"\ntarget = "leader"\nfrom_s = 3.0\n')
    runs = [
        clew.rehearse("grove", robots=2, faults=faults)
        for faults in ("leader-killed", "mine.toml", plan, [clew.kill("leader", from_s=3.0)])
    ]
    assert [run.at(20.0).leader for run in runs] == [2, 2, 2, 2]
    assert [len(run.faults) for run in runs] == [1, 1, 1, 1]
