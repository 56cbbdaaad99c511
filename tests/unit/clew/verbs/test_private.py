"""Files of a run are private to the user, and nothing is written through a link."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.campaigns import clew, scene
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.run_files import read_verdict, save_verdict

LOSSY = """name = "lossy"
[[rule]]
fault = "drop"
probability = 0.01
"""


@pytest.fixture(autouse=True)
def open_to_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.chdir(tmp_path)
    before = os.umask(0)
    yield
    os.umask(before)


def readable_by_others(folder: Path) -> list[str]:
    """The folder itself counts, and all that is in it."""
    return [str(path) for path in (folder, *folder.rglob("*")) if path.stat().st_mode & 0o077]


def test_a_rehearsed_run_and_all_that_is_made_of_it_is_the_users_alone(tmp_path: Path) -> None:
    (tmp_path / "lossy.toml").write_text(LOSSY, encoding="utf-8")
    ran = clew(
        "rehearse", scene(tmp_path / "scene.json"), "--faults", tmp_path / "lossy.toml", "--out", "run"
    )
    assert ran.exit_code == 0
    for made in (["report"], ["figures", "--format", "svg"], ["log", "export", "--to", "csv"]):
        assert clew(*made, "run").exit_code == 0
    names = {path.name for path in Path("run").rglob("*")}
    assert {"events.jsonl", "verdict.json", "faults.toml", "inputs", "report.html", "figures", "csv"} <= names
    assert readable_by_others(Path("run")) == []


def test_a_run_in_runs_is_the_users_alone(tmp_path: Path) -> None:
    assert clew("rehearse", scene(tmp_path / "scene.json")).exit_code == 0
    assert readable_by_others(Path("runs/latest").resolve()) == []


def test_a_campaign_is_the_users_alone() -> None:
    assert (
        clew(
            "campaign", "--faults", "swarm", "--seeds", "1", "--keep", "--jobs", "1", "--out", "all"
        ).exit_code
        < 2
    )
    assert {path.suffix for path in Path("all/drawn").iterdir()} == {".toml"}
    assert readable_by_others(Path("all")) == []


def test_a_campaign_of_tight_scenes_is_the_users_alone(tmp_path: Path) -> None:
    scenes = scene(tmp_path / "scenes" / "a.json").parent
    ran = clew("campaign", "--scenes", scenes, "--tight", "0.9", "--jobs", "1", "--out", "all")
    assert ran.exit_code < 2
    assert readable_by_others(Path("all")) == []


@pytest.mark.parametrize("theirs", ["theirs", "nowhere"])
def test_a_verdict_is_not_written_through_a_link(tmp_path: Path, theirs: str) -> None:
    (tmp_path / "theirs").write_text("theirs", encoding="utf-8")
    (tmp_path / VERDICT_FILE).symlink_to(theirs)
    save_verdict(GOOD, tmp_path)
    assert read_verdict(tmp_path) == GOOD
    assert (tmp_path / "theirs").read_text(encoding="utf-8") == "theirs"
    assert not (tmp_path / "nowhere").exists()


def test_a_report_is_not_written_through_a_link(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", numbered(AT_REST))
    assert clew("report", run).exit_code == 0
    other = run / "report.html"
    before = other.read_bytes()
    (tmp_path / "link.html").symlink_to(other)
    said = clew("report", run, "--out", tmp_path / "link.html")
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert other.read_bytes() == before


def test_an_export_is_not_written_through_a_link(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", numbered(AT_REST))
    (tmp_path / "theirs").write_text("theirs", encoding="utf-8")
    (run / "events.mcap").symlink_to(tmp_path / "theirs")
    clew("log", "export", run, "--to", "mcap")
    assert (tmp_path / "theirs").read_text(encoding="utf-8") == "theirs"
