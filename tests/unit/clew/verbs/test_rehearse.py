"""`clew rehearse`: what it says while it plays."""

import errno
import json
import re
from pathlib import Path

import pytest

import clew as api
from clew.fleet.folder import LATEST
from protocol import law_files, laws
from protocol.errors import UsageError
from tests.support.campaigns import clew, scene


def test_a_quiet_rehearsal_says_its_result_and_nothing_before(tmp_path: Path) -> None:
    played = scene(tmp_path / "scene.json")
    told, quiet = (
        clew("rehearse", played, "--out", tmp_path / name, *options)
        for name, options in (("told", []), ("quiet", ["--quiet"]))
    )
    assert "rehearsal: t=" in told.stderr
    assert quiet.stderr == ""
    results = [re.sub(r"simulated in [\d.]+ s", "simulated", said.stdout) for said in (told, quiet)]
    assert results[1] == results[0].replace("told", "quiet") != ""


def test_what_a_law_prints_is_no_part_of_the_result(tmp_path: Path) -> None:
    law = tmp_path / "mylaw.py"
    law.write_text("def talks(seen):\n    print('here')\n")
    asked = ("rehearse", "grove", "-n", "1", "--law", f"{law}:talks", "--json", "--out", tmp_path / "run")
    said = clew(*asked)
    assert json.loads(said.stdout)["no_route"]
    assert "here\n" in said.stderr


LAW = "def mine(seen):\n    return seen.step_to(seen.goal)\n"


@pytest.fixture
def law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A law of a file in the current folder; this process has been told of no other."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(law_files, "_folders", {})
    monkeypatch.setattr(laws, "_loaded", {})
    (tmp_path / "mylaw.py").write_text(LAW)
    return "mylaw.py:mine"


def test_the_newest_run_is_rehearsed_again_by_the_link_to_it_also_under_a_law_of_a_file(law: str) -> None:
    assert clew("rehearse", scene(Path("scene.json")), "-n", "1", "--law", law, "--quiet").exit_code == 0
    Path("mylaw.py").unlink()
    law_files._folders.clear()
    said = clew("rehearse", LATEST / "scenario.toml", "--quiet")
    assert (said.exit_code, said.stderr) == (0, "")


@pytest.mark.parametrize("asked", [[], ["--out", "new/run"]])
def test_a_rehearsal_that_cannot_begin_leaves_nothing_and_the_link_to_the_newest_run(
    law: str, asked: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    played = scene(Path("scene.json"))
    assert clew("rehearse", played, "-n", "1", "--quiet").exit_code == 0
    before, newest = sorted(Path().rglob("*")), LATEST.resolve()
    monkeypatch.setattr("world.record.run_files.write_whole", _full)
    said = clew("rehearse", played, "-n", "1", "--law", law, *asked)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    with pytest.raises(UsageError, match="No space left"):
        api.rehearse(played, robots=1)
    assert sorted(Path().rglob("*")) == before
    assert LATEST.resolve() == newest


def _full(path: Path, _: bytes) -> None:
    raise OSError(errno.ENOSPC, "No space left on device", str(path))


def test_the_folder_of_a_run_in_place_of_its_scenario_is_named_as_that(tmp_path: Path) -> None:
    (tmp_path / "scenario.toml").touch()
    refusal = f"Error: {tmp_path}: is the folder of a run; its scenario is {tmp_path}/scenario.toml\n"
    said = clew("rehearse", tmp_path)
    assert (said.exit_code, said.stderr) == (2, refusal)
