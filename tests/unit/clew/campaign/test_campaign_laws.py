"""Campaigns under a law of a file: all episodes have the same one, which is kept with them."""

import json
import os
from pathlib import Path

import pytest
from click.testing import Result

from protocol.root import ROOT
from tests.support.campaigns import clew, scene, told
from tests.support.deadline import DEADLINE_S
from world.scenario.reading import SCENARIOS


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scene and a law."""
    monkeypatch.chdir(tmp_path)
    scene(tmp_path / "one.json")
    (tmp_path / "mylaw.py").write_text("def mine(seen): return seen.step_to(seen.goal)")
    return tmp_path


def campaign(law: str | None, scene: str = "one.json") -> Result:
    words = () if law is None else ("--law", law)
    return clew("campaign", scene, "-n", "1", "--jobs", "1", *words, "--out", "out")


def test_episodes_have_the_law_as_it_was_and_are_played_again_when_its_file_has_changed(here: Path) -> None:
    assert campaign("mylaw.py:mine").exit_code == 0
    name, (first,) = told(here / "out")["law"], told(here / "out")["episodes"]
    assert name.startswith("mylaw.py:mine@")
    (here / "mylaw.py").write_text("def mine(seen): return 'never'")
    assert f"--law out/{name} " in first["replay"]
    again = json.loads(clew(*first["replay"].split()[1:], "--json").stdout)
    assert (again["law"], again["sim_s"]) == (name, first["sim_s"])
    assert campaign("mylaw.py:mine").exit_code == 1
    assert "never" in told(here / "out")["episodes"][0]["reason"]


def test_no_copy_of_a_law_replaces_a_file_that_no_campaign_wrote(here: Path) -> None:
    (here / "out").mkdir()
    (here / "out" / "mylaw.py").write_text("def mine(seen): return 'mine'")
    said = campaign("mylaw.py:mine")
    refusal = (
        "Error: cannot write out/mylaw.py: it is there, and bears no mark of Clew, so it would be lost\n"
    )
    assert (said.exit_code, said.stderr) == (2, refusal)
    assert [path.name for path in (here / "out").iterdir()] == ["mylaw.py"]
    (here / "out" / "mylaw.py").write_bytes((here / "mylaw.py").read_bytes())
    assert campaign("mylaw.py:mine").exit_code == 0


@pytest.mark.parametrize(
    ("others", "why"),
    [((), "it is no regular file"), (("episodes.jsonl",), "it is there, and is no file")],
    ids=["in a new folder", "in a campaign's"],
)
def test_a_pipe_where_the_copy_of_a_law_goes_is_named_and_not_waited_for(
    here: Path, others: tuple[str, ...], why: str
) -> None:
    (here / "out").mkdir()
    os.mkfifo(here / "out" / "mylaw.py")
    for each in others:
        (here / "out" / each).touch()
    said = campaign("mylaw.py:mine")
    assert (said.exit_code, said.stderr) == (2, f"Error: cannot write out/mylaw.py: {why}\n")


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_what_a_law_prints_is_no_part_of_the_result(
    here: Path, capfd: pytest.CaptureFixture[str], jobs: str
) -> None:
    (here / "mylaw.py").write_text("print('loaded')\ndef mine(seen):\n    print('here')\n")
    asked = ("campaign", "one.json", "-n", "1", "--jobs", jobs, "--seeds", "1-2", "--law", "mylaw.py:mine")
    said = clew(*asked, "--json", "--out", "out")
    workers = capfd.readouterr()
    assert json.loads(said.stdout)["episodes"]
    assert workers.out == ""
    assert "here\n" in said.stderr + workers.err


def test_a_law_that_never_returns_is_named_where_the_time_is_up(here: Path) -> None:
    """The law itself ends the wall-clock limit once it is asked: a slow machine may take long until then."""
    (here / "mylaw.py").write_text(
        "import signal, threading\n"
        "def mine(seen):\n"
        "    signal.setitimer(signal.ITIMER_REAL, 0.01)\n"
        "    threading.Event().wait()\n"
    )
    asked = ("-n", "1", "--jobs", "1", "--law", "mylaw.py:mine", "--wall-s-max", str(DEADLINE_S))
    clew("campaign", "one.json", *asked, "--out", "out")
    (first,) = told(here / "out")["episodes"]
    assert "struck at t=" in first["reason"]
    assert f", in the law {told(here / 'out')['law']}, which may never return" in first["reason"]


def test_the_line_that_replays_a_surprise_names_the_program_as_this_folder_finds_it(here: Path) -> None:
    (here / "mylaw.py").write_text("def mine(seen): raise KeyError('typo')\n")
    said = campaign("mylaw.py:mine", "grove").stdout.splitlines()
    assert any(line.startswith(f"    {ROOT / 'launch' / 'clew'} rehearse ") for line in said)


def test_a_law_that_raises_is_a_surprise_where_no_scene_says_whether_there_is_a_way(here: Path) -> None:
    (here / "mylaw.py").write_text("def mine(seen): raise KeyError('typo')\n")
    assert campaign("mylaw.py:mine", "grove").exit_code == 1
    (surprise,) = told(here / "out")["surprises"]
    assert (surprise["surprise"], surprise["solvable"]) == ("crashed", None)
    assert "KeyError: 'typo' (mylaw.py:1 mine" in surprise["reason"]


def test_of_many_surprises_the_first_are_printed_and_the_others_counted(here: Path) -> None:
    (here / "mylaw.py").write_text("def mine(seen): raise ValueError")
    asked = ("campaign", "one.json", "-n", "1", "--jobs", "1", "--seeds", "1-22", "--law", "mylaw.py:mine")
    said = clew(*asked, "--out", "out").stdout.splitlines()
    printed = [line for line in said if line.startswith("crashed: ")]
    assert [", seed 20: " in printed[-1], len(printed)] == [True, 20]
    assert said[-2] == "and 2 more surprises: `surprises` in out/campaign.json has all"
    assert "surprises: 22." in said[-1]


def test_an_episode_is_played_again_when_the_law_of_its_scenario_has_changed(here: Path) -> None:
    text = (SCENARIOS / "paper.toml").read_text()
    (here / "one.toml").write_text(text.replace('law = "printed"', 'law = "mylaw.py:mine"'))
    campaign(None, "one.toml")
    assert "never" not in told(here / "out")["episodes"][0]["reason"]
    (here / "mylaw.py").write_text("def mine(seen): return 'never'")
    campaign(None, "one.toml")
    assert "never" in told(here / "out")["episodes"][0]["reason"]


@pytest.mark.parametrize("law", ["none.py:mine", "mylaw.py:mien", "mylaw.py"])
def test_a_law_that_is_not_in_its_file_is_refused_before_anything_is_played(here: Path, law: str) -> None:
    refused = campaign(law)
    assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
    assert not (here / "out").exists()
