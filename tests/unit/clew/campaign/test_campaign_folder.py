"""The folder of a campaign is its own."""

import fcntl
import json
import signal
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

from clew.campaign.episode import Episode, Outcome, play
from protocol.files.writing import write_whole
from tests.support.campaigns import clew, scene


def test_a_campaign_never_writes_into_a_runs_folder(tmp_path: Path) -> None:
    played, run = scene(tmp_path / "one.json"), tmp_path / "run"
    run.mkdir()
    (run / "events.jsonl").touch()
    said = clew("campaign", played, "--jobs", "1", "--out", run)
    assert said.exit_code == 2
    assert "is a run's folder, and a campaign never writes into one" in said.stderr
    assert [each.name for each in run.iterdir()] == ["events.jsonl"]


def test_a_second_campaign_in_the_same_folder_is_refused_while_the_first_goes_on(tmp_path: Path) -> None:
    played, out = scene(tmp_path / "one.json"), tmp_path / "out"
    asked = ("campaign", played, "--jobs", "1", "--judge-every", "0", "--out", out)
    out.mkdir()
    with (out / "episodes.jsonl").open("ab") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        said = clew(*asked)
        assert (said.exit_code, said.stderr) == (2, f"Error: {out}: another campaign is going on there\n")
    assert not (out / "campaign.json").exists()
    assert clew(*asked).exit_code == 0


def test_a_campaign_holds_its_folder_until_its_summary_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    played, out = scene(tmp_path / "one.json"), tmp_path / "out"
    seen: list[str] = []

    def refused(when: str) -> None:
        with (out / "episodes.jsonl").open("ab") as file, pytest.raises(BlockingIOError):
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        seen.append(when)

    def playing(episode: Episode) -> Outcome:
        refused("played")
        return play(episode)

    def writing(path: Path, text: bytes) -> None:
        refused(path.name)
        write_whole(path, text)

    monkeypatch.setattr("clew.campaign.executors.pool.play", playing)
    monkeypatch.setattr("clew.campaign.campaign.write_whole", writing)
    assert clew("campaign", played, "--jobs", "1", "--judge-every", "0", "--out", out).exit_code == 0
    assert seen == ["played", "campaign.json"]


def test_an_outcome_that_was_written_as_the_interrupt_came_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Interrupted(FileIO):
        def write(self, text: Any, /) -> int:  # noqa: ANN401 - FileIO's own signature
            written = super().write(text)
            signal.raise_signal(signal.SIGINT)
            return written

    monkeypatch.setattr("clew.campaign.campaign._held", lambda path: Interrupted(path, "a"))
    out = tmp_path / "out"
    assert clew("campaign", scene(tmp_path / "one.json"), "--jobs", "1", "--out", out).exit_code == 130
    told = json.loads((out / "campaign.json").read_text())
    assert (told["interrupted"], told["all"]["episodes"]) == (True, 1)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('name = "mine"\n[[rule]]\nfault = "drop"\n', "is a fault plan, not a scenario"),
        ("", "must have the field"),
        ("[fleet", "is not TOML"),
    ],
)
def test_a_file_that_is_named_and_is_no_scene_is_refused_and_not_played(
    tmp_path: Path, text: str, why: str
) -> None:
    (tmp_path / "mine.toml").write_text(text)
    said = clew("campaign", tmp_path / "mine.toml", "--jobs", "1", "--out", tmp_path / "out")
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert f"{tmp_path}/mine.toml" in said.stderr
    assert why in said.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("foreign", ['{"ok": true, "name": "summer sale"}\n', "\xff\xfe"])
def test_a_campaign_never_replaces_a_file_that_no_campaign_wrote(tmp_path: Path, foreign: str) -> None:
    played, out = scene(tmp_path / "one.json"), tmp_path / "out"
    out.mkdir()
    (out / "campaign.json").write_text(foreign, encoding="latin-1")
    said = clew("campaign", played, "--jobs", "1", "--out", out)
    path = out / "campaign.json"
    refusal = f"Error: cannot write {path}: it is there, and bears no mark of Clew, so it would be lost\n"
    assert (said.exit_code, said.stderr) == (2, refusal)
    assert list(out.iterdir()) == [path]
    assert path.read_text(encoding="latin-1") == foreign


@pytest.mark.parametrize("name", ["campaign.json", "episodes.jsonl"])
def test_a_campaign_names_the_file_that_is_in_its_way(tmp_path: Path, name: str) -> None:
    played, path = scene(tmp_path / "one.json"), tmp_path / "out" / name
    path.mkdir(parents=True)
    said = clew("campaign", played, "--jobs", "1", "--out", path.parent)
    assert (said.exit_code, said.stderr) == (2, f"Error: cannot write {path}: Is a directory\n")


def test_a_campaign_replaces_its_own_summary_and_an_empty_one(tmp_path: Path) -> None:
    played, path = scene(tmp_path / "one.json"), tmp_path / "out" / "campaign.json"
    asked = ("campaign", played, "-n", "1", "--jobs", "1", "--judge-every", "0", "--out", path.parent)
    assert [clew(*asked).exit_code for _ in range(2)] == [0, 0]
    whole = path.read_bytes()
    path.write_bytes(b"")
    assert clew(*asked).exit_code == 0
    assert path.read_bytes() == whole


def test_no_tight_scene_replaces_a_file_that_no_campaign_wrote(tmp_path: Path) -> None:
    mine = scene(tmp_path / "scenes" / "posts" / "one.json")
    before = mine.read_bytes()
    asked = ("campaign", mine, "-n", "1", "--tight", "0.9", "--jobs", "1", "--judge-every", "0", "--out")
    said = clew(*asked, tmp_path)
    refusal = f"Error: cannot write {mine}: it is there, and bears no mark of Clew, so it would be lost\n"
    assert (said.exit_code, said.stderr) == (2, refusal)
    assert mine.read_bytes() == before
    other = tmp_path / "out" / "scenes" / "posts" / "one.json"
    other.parent.mkdir(parents=True)
    other.write_text(json.dumps(json.loads(before) | {"name": "mine"}), encoding="utf-8")
    assert "bears no mark of Clew" in clew(*asked, tmp_path / "out").stderr
    other.write_bytes(b"")
    for edited in ({}, {"name": "edited"}):
        mine.write_text(json.dumps(json.loads(before) | edited), encoding="utf-8")
        assert clew(*asked, tmp_path / "out").exit_code == 0, "it is our scene, or nothing"
