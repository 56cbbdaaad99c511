"""The folder of a campaign is its own."""

from pathlib import Path

from tests.support.campaigns import clew, scene


def test_a_campaign_never_writes_into_a_runs_folder(tmp_path: Path) -> None:
    played, run = scene(tmp_path / "one.json"), tmp_path / "run"
    run.mkdir()
    (run / "events.jsonl").touch()
    said = clew("campaign", played, "--jobs", "1", "--out", run)
    assert said.exit_code == 2
    assert "is a run's folder, and a campaign never writes into one" in said.stderr
    assert [each.name for each in run.iterdir()] == ["events.jsonl"]
