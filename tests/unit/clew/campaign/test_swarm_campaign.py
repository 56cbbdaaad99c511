import json
import shlex
from pathlib import Path

import pytest
from click.testing import Result

from clew.campaign.campaign import SEEN_BY
from protocol.faults.plan import Plan
from protocol.faults.plan_text import plan_text
from protocol.faults.rules import Kill
from tests.support.campaigns import clew, scene, told

SEEDS = "5,20,24"  # of the first forty those that are soon over


def swarm(out: Path, *more: str | Path) -> Result:
    return clew("campaign", "--faults", "swarm", "--seeds", SEEDS, "--jobs", "1", "--out", out, *more)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("swarm") / "out"
    swarm(out, "--keep")
    return out


def test_each_seed_is_an_episode_with_its_mode_its_classes_and_its_injections(kept: Path) -> None:
    episodes = told(kept)["episodes"]
    assert [each["seed"] for each in episodes] == [5, 20, 24]
    assert all(each["mode"] in {"safety", "liveness"} and each["classes"] for each in episodes)
    assert any(each["injected"] for each in episodes)


def test_an_episode_counts_in_each_of_its_classes_and_once_in_the_total(kept: Path) -> None:
    campaign = told(kept)
    assert campaign["classes"]["all"]["episodes"] == 3
    drawn = [name for each in campaign["episodes"] for name in each["classes"]]
    assert {name: figures["episodes"] for name, figures in campaign["classes"].items() if name != "all"} == {
        name: drawn.count(name) for name in drawn
    }


def test_uncovered_situations_are_listed_and_fail_only_a_long_campaign(kept: Path) -> None:
    campaign = told(kept)
    assert campaign["uncovered"]
    assert campaign["ok"] == (not campaign["surprises"])
    assert SEEN_BY > 3


def test_the_replay_line_replays_the_episode(kept: Path, tmp_path: Path) -> None:
    episode = told(kept)["episodes"][0]
    clew(*shlex.split(episode["replay"])[1:], "--out", tmp_path / "run")
    verdict = json.loads((tmp_path / "run" / "verdict.json").read_text(encoding="utf-8"))
    assert (verdict["sim_s"], verdict["path_m"]) == (episode["sim_s"], episode["path_m"])


def test_without_written_files_the_replay_line_writes_them(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    swarm(tmp_path / "out")
    assert not (tmp_path / "out" / "drawn").exists(), "nothing surprises"
    episode = told(tmp_path / "out")["episodes"][2]
    line = json.loads((tmp_path / "out" / "episodes.jsonl").read_text(encoding="utf-8").splitlines()[2])
    assert line["replay"] == episode["replay"]
    monkeypatch.chdir(tmp_path)
    assert clew(*shlex.split(episode["replay"])[1:]).exit_code == 0
    (again,) = (tmp_path / "runs").iterdir()
    (same,) = told(again)["episodes"]
    assert (same["key"], same["sim_s"], same["path_m"]) == tuple(
        episode[name] for name in ("key", "sim_s", "path_m")
    )
    assert (again / "drawn" / f"{episode['seed']}.toml").exists()
    assert same["replay"].split()[:3] == ["./launch/clew", "rehearse", f"runs/{again.name}/drawn/24.toml"]
    assert told(kept)["episodes"][2]["replay"].split()[1] == "rehearse", "--keep has written it"


def test_the_same_command_again_plays_nothing_twice(kept: Path) -> None:
    lines = (kept / "episodes.jsonl").read_bytes()
    assert swarm(kept, "--keep").exit_code == 0
    assert (kept / "episodes.jsonl").read_bytes() == lines


def test_no_drawn_world_replaces_a_file_that_no_campaign_wrote(tmp_path: Path) -> None:
    mine = tmp_path / "drawn" / "24.toml"
    mine.parent.mkdir()
    mine.write_bytes(b'name = "mine"\n')
    said = swarm(tmp_path, "--keep")
    assert (said.exit_code, said.stderr) == (
        2,
        f"Error: cannot write {mine}: it is there, and bears no mark of Clew, so it would be lost\n",
    )
    assert [*tmp_path.iterdir(), *mine.parent.iterdir()] == [mine.parent, mine]
    assert mine.read_bytes() == b'name = "mine"\n'


def test_drawn_worlds_and_given_scenes_exclude_each_other(tmp_path: Path) -> None:
    field = scene(tmp_path / "scenes" / "one.json")
    assert clew("campaign").exit_code == 2
    for more in (["--scenes", str(field)], ["--robots", "3"], ["--law", "printed"], ["--tight", "0.9"]):
        assert swarm(tmp_path / "out", *more).exit_code == 2


def test_robots_killed_by_a_fault_plan_need_not_arrive(tmp_path: Path) -> None:
    field = scene(tmp_path / "scenes" / "one.json")
    plan = Plan(name="tail", rules=(Kill(target="tail", from_s=1.0),))
    (tmp_path / "tail.toml").write_text(plan_text(plan), encoding="utf-8")
    out = tmp_path / "out"
    asked = ("--scenes", field, "--robots", "3", "--faults", tmp_path / "tail.toml", "--jobs", "1")
    assert clew("campaign", *asked, "--out", out).exit_code == 0
    (episode,) = told(out)["episodes"]
    assert (episode["robots"], episode["robots_arrived"], episode["injected"]) == (3, 2, {"kill": 1})
    assert "--faults" in episode["replay"]
