"""`clew rehearse`: what it says while it plays."""

from pathlib import Path

from tests.support.campaigns import clew, scene


def test_a_quiet_rehearsal_says_its_result_and_nothing_before(tmp_path: Path) -> None:
    played = scene(tmp_path / "scene.json")
    told, quiet = (
        clew("rehearse", played, "--out", tmp_path / name, *options)
        for name, options in (("told", []), ("quiet", ["--quiet"]))
    )
    assert "rehearsal: t=" in told.stderr
    assert quiet.stderr == ""
    assert quiet.stdout == told.stdout.replace("told", "quiet") != ""
