"""The plugin, in sessions of pytest of their own: what tests get, and what they say when they fail."""

import re
import sys
from pathlib import Path

import pytest

from tests.support.processes.plugin import HEAD, played

STAGE = """
@pytest.mark.clew(robots=1)
def test_stage(clew_rehearsal, clew_fleet):
    assert type(clew_rehearsal).__name__ == type(clew_fleet).__name__ == "{stage}Fleet"
"""


def test_each_seed_is_a_test_of_its_own_with_its_own_folder_also_in_parallel(tmp_path: Path) -> None:
    test = """
@pytest.mark.clew(robots=1, seeds=range(2))
def test_arrives(clew_rehearsal, clew_seed, tmp_path):
    run = clew_rehearsal.finish()
    assert run.seed == clew_seed
    assert run.folder.parent == tmp_path
    assert run.ok
"""
    code, said = played(tmp_path, test, "-v", "-n", "2")
    assert code == 0, said
    assert all(f"test_arrives[seed={seed}]" in said for seed in range(2))


def test_a_stage_can_be_chosen_for_all_fleets(tmp_path: Path) -> None:
    """Here live; below, where a failing test is not played again, rehearsed."""
    code, said = played(tmp_path, STAGE.format(stage="Launched"), "--clew-stage=live")
    assert code == 0, said


def test_a_failing_test_says_what_broke_the_seed_the_faults_that_matter_the_replay_and_the_page(
    tmp_path: Path,
) -> None:
    test = """
@pytest.mark.clew(robots=1, seeds=range(2))
def test_has_that_seed(clew_rehearsal, clew_seed):
    assert clew_rehearsal.asked.seed == clew_seed

@pytest.mark.clew(robots=3)
def test_all_arrive(clew_rehearsal):
    fleet = clew_rehearsal
    fleet.link(1, 2).drop(0.1)
    fleet.tail.kill(step=2)
    fleet.until("step.planned", step=1)
    fleet.link(2, 3).delay(0.1)
    run = fleet.finish()
    assert run.verdict.robots_arrived == 3
"""
    code, said = played(tmp_path, test, "-v", "--clew-seed=5", f"--basetemp={tmp_path / 'base'}")
    assert code == 1, said
    assert "test_has_that_seed[seed=5] PASSED" in said
    assert "1 failed, 1 passed" in said
    section = said.partition(" clew_rehearsal, seed 5 ")[2].partition("short test summary")[0]
    assert "what broke first: the test's own claim" in section
    assert "seed: 5\n" in section
    assert "faults: 1 of 3 that were given matter:" in section
    assert '    [[rule]]\n    fault = "kill"\n    name = "kill-2"\n' in section
    assert "drop" not in section
    assert "run the test again:      pytest test_mine.py::test_all_arrive --clew-seed=5" in section
    [folder] = (tmp_path / "base").glob("test_all_arrive0/clew_rehearsal")
    assert (
        f"{sys.executable} -m clew.cli rehearse {folder}/scenario.toml --seed 5 --faults {folder}/shrunk.toml"
        in section
    )
    assert f"page:                    {folder}/report.html" in section
    assert {each.name for each in folder.parent.iterdir()} == {"clew_rehearsal"}  # trials leave nothing
    shrunk = (folder / "shrunk.toml").read_text(encoding="utf-8")
    assert "kill-2" in shrunk


def test_a_failing_test_is_not_played_again_where_that_is_asked_for(tmp_path: Path) -> None:
    test = """
@pytest.mark.clew(robots=2)
def test_ends_at_once(clew_rehearsal):
    clew_rehearsal.link(1, 2).drop(0.1)
    clew_rehearsal.tail.kill(from_s=2.0)
    clew_rehearsal.finish()
    with open("played", "a") as file:
        file.write("x")
    assert False
"""
    test += STAGE.format(stage="Rehearsed")
    code, said = played(tmp_path, test, "--clew-no-shrink", "--clew-stage=rehearsal")
    assert code == 1, said
    assert "1 failed, 1 passed" in said
    assert [(each.name, each.read_text()) for each in tmp_path.rglob("played")] == [("played", "x")]
    assert "faults: all that were given; --clew-no-shrink leaves out the search for those that matter" in said
    assert 'name = "drop-1"' in said
    assert 'name = "kill-2"' in said
    assert "/clew_rehearsal/shrunk.toml" in said


def test_a_failing_test_that_is_a_coroutine_is_awaited_when_it_is_played_again(tmp_path: Path) -> None:
    test = """
import asyncio

@pytest.mark.asyncio
@pytest.mark.clew(robots=2)
async def test_all_arrive(clew_rehearsal):
    clew_rehearsal.link(1, 2).drop(0.1)
    clew_rehearsal.tail.kill(step=2)
    run = await asyncio.to_thread(clew_rehearsal.finish)
    assert run.verdict.robots_arrived == 2
"""
    code, said = played(tmp_path, test, "-p", "asyncio")
    assert code == 1, said
    assert "faults: 1 of 2 that were given matter:" in said
    assert "never awaited" not in said


FAILING = """
played = []

@pytest.mark.clew(robots=2, faults=[clew.kill(1, from_s=2.0), clew.kill(2, from_s=2.0)])
def test_survives(clew_rehearsal):
    assert clew_rehearsal.finish().ok

def test_waits_in_vain(clew_rehearsal):
    clew_rehearsal.until("router.lost", timeout_s=0.5)

@pytest.mark.clew(robots=1)
def test_refused(clew_rehearsal):
    clew_rehearsal.until("step.planned")
    clew_rehearsal.tail.kill(at="after_plan")

@pytest.mark.clew(robots=1)
def test_once(clew_rehearsal):
    clew_rehearsal.robot(1).slow(by_s=0.01, from_s=1.0)
    clew_rehearsal.finish()
    played.append(1)
    assert len(played) > 1

def test_has_no_such_robot(clew_rehearsal):
    clew_rehearsal.until("step.planned")
    clew_rehearsal.robot(9).kill()

def test_asks_in_vain(clew_rehearsal):
    clew_rehearsal.link("r1", "r99").drop(0.3)

@pytest.mark.clew(robots=2)
def test_late(clew_rehearsal):
    clew_rehearsal.link(1, 2).drop(0.5)
    clew_rehearsal.tail.kill(step=99)
    assert clew_rehearsal.finish().ok

@pytest.mark.clew(robots=2, must_strike=False)
def test_may_be_late(clew_rehearsal):
    clew_rehearsal.tail.kill(step=99)
    assert clew_rehearsal.finish().ok

@pytest.mark.clew(robots=2)
def test_is_left_early(clew_rehearsal):
    clew_rehearsal.tail.kill(step=2)
    clew_rehearsal.until("step.planned", step=1)

@pytest.mark.clew(scenario="paper", robots=2)
class TestPaper:
    @pytest.mark.clew(robots=1, law="certified", faults=[clew.drop(p=0.1)], must_strike=False)
    def test_adds_up(self, clew_rehearsal):
        fleet = clew_rehearsal.asked.scenario
        assert (fleet.name, fleet.fleet.robots, fleet.law.law) == ("paper", 1, "certified")
        assert clew_rehearsal.plan.names == ["drop-1"]
"""


@pytest.fixture(scope="module")
def failures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What one session says of each of these tests that fails; two of them pass."""
    code, said = played(tmp_path_factory.mktemp("failing"), FAILING)
    assert code == 1, said
    assert "8 failed, 2 passed" in said
    _, *parts = re.split(r"^_+ ([\w.]+) _+$", said.partition("short test summary")[0], flags=re.MULTILINE)
    return dict(zip(parts[::2], parts[1::2], strict=True))


def test_a_run_that_broke_its_promises_says_so_first(failures: dict[str, str]) -> None:
    assert "what broke first: every robot has died" in failures["test_survives"]
    said = failures["test_waits_in_vain"]
    assert re.search(r"router.lost did not come: 0\.\d simulated s have passed", said)
    assert "faults: none were given" in said
    assert "def until" not in said  # the line of the test is shown, and not ours


@pytest.mark.parametrize(
    ("test", "why"),
    [("test_refused", "windows and points are for plans"), ("test_has_no_such_robot", "r1 to r5, got 9")],
)
def test_a_mistake_in_a_test_is_not_taken_for_its_claim(
    failures: dict[str, str], test: str, why: str
) -> None:
    said = failures[test]
    assert why in said
    assert "what broke first: nothing in the fleet: the test asks for what cannot be done\n" in said
    assert f"run the test again:      pytest test_mine.py::{test} --clew-seed=1\n" in said
    assert not re.search("^(seed|faults|rehearse its fleet|page):", said, flags=re.MULTILINE)


def test_a_test_that_fails_only_once_keeps_its_whole_plan(failures: dict[str, str]) -> None:
    said = failures["test_once"]
    assert "does not fail in the same way when it is played again" in said
    assert 'fault = "slow"' in said


def test_what_a_test_asks_for_in_vain_is_shown_at_its_own_line(failures: dict[str, str]) -> None:
    said = failures["test_asks_in_vain"]
    assert "test_mine.py:" in said
    assert "must be a robot of the fleet, r1 to r5, got r99" in said
    assert "def inject" not in said
    assert "protocol/faults/fit.py" not in said


def test_the_markers_of_a_class_and_of_a_test_add_up_the_nearest_first(failures: dict[str, str]) -> None:
    assert not [each for each in failures if each.endswith("test_adds_up")]


def test_a_test_whose_fault_never_struck_fails_unless_it_says_that_this_may_be(
    failures: dict[str, str],
) -> None:
    late, early = failures["test_late"], failures["test_is_left_early"]
    may_be = "if that may be: @pytest.mark.clew(must_strike=False)"
    assert f"the test has passed, but kill-2 never struck; {may_be}" in late
    assert "faults: 1 of 2 that were given matter:" in late
    assert "but kill-1 never struck" in early
    for said in (late, early):
        assert "what broke first: nothing in the fleet: a fault of the test never struck" in said
        assert "told to end" not in said  # the plugin has told it
    assert "test_may_be_late" not in failures


WRONG = {
    "robot": {"robot=4": "@pytest.mark.clew takes scenario, robots, seeds"},
    "seeds": {"seeds=5": "seeds must be a list or a range, got 5"},
    "no_seeds": {"seeds=range(0)": "seeds must not be empty, got range(0, 0)"},
    "values": {
        'scenario="groove"': "unknown scenario 'groove'",
        "faults=[clew.kill(9)]": "must be a robot of the fleet, r1 to r5, got r9",
        'robots="x"': "robots: must be an integer, got 'x'",
    },
}


def test_a_wrong_marker_fails_its_test_and_says_why(tmp_path: Path) -> None:
    test = "@pytest.mark.clew({})\ndef test_a{}(clew_rehearsal, clew_seed): pass\n"
    complaints: dict[str, str] = {}
    for name, wrong in WRONG.items():
        tests = [test.format(asked, number) for number, asked in enumerate(wrong)]
        (tmp_path / f"test_{name}.py").write_text("\n".join([HEAD, *tests]), encoding="utf-8")
        complaints |= {f"test_{name}.py::test_a{place}": why for place, why in enumerate(wrong.values())}
    code, said = played(tmp_path, "", "--continue-on-collection-errors")
    assert code == 1, said
    for place, why in complaints.items():
        assert re.search(f"^{place}: .*{re.escape(why)}", said, flags=re.MULTILINE), said
    assert "Error: " not in said  # no traceback
    assert "pytest_plugin.py" not in said


def test_tests_without_a_fleet_load_nothing_of_ours(tmp_path: Path) -> None:
    test = """
import sys

def test_a(clew_seed):
    assert not [each for each in sys.modules if each.startswith(("clew.api", "world", "agents", "protocol"))]
"""
    code, said = played(tmp_path, test)
    assert code == 0, said
