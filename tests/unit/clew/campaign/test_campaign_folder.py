"""The folder of a campaign is its own."""

from pathlib import Path

import pytest

from tests.support.campaigns import clew, scene


def test_a_campaign_never_writes_into_a_runs_folder(tmp_path: Path) -> None:
    played, run = scene(tmp_path / "one.json"), tmp_path / "run"
    run.mkdir()
    (run / "events.jsonl").touch()
    said = clew("campaign", played, "--jobs", "1", "--out", run)
    assert said.exit_code == 2
    assert "is a run's folder, and a campaign never writes into one" in said.stderr
    assert [each.name for each in run.iterdir()] == ["events.jsonl"]


@pytest.mark.parametrize("foreign", ['{"ok": "yes", "name": "summer sale"}\n', "", "\xff\xfe"])
def test_a_campaign_never_replaces_a_file_that_no_campaign_wrote(tmp_path: Path, foreign: str) -> None:
    played, out = scene(tmp_path / "one.json"), tmp_path / "out"
    out.mkdir()
    (out / "campaign.json").write_text(foreign, encoding="latin-1")
    said = clew("campaign", played, "--jobs", "1", "--out", out)
    refusal = f"Error: {out}/campaign.json: no campaign of Clew wrote this file, and one would replace it\n"
    assert (said.exit_code, said.stderr) == (2, refusal)
    assert [each.name for each in out.iterdir()] == ["campaign.json"]
    assert (out / "campaign.json").read_text(encoding="latin-1") == foreign
