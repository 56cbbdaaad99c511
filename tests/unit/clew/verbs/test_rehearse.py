"""`clew rehearse`: what it says while it plays."""

import json
import re
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
    results = [re.sub(r"simulated in [\d.]+ s", "simulated", said.stdout) for said in (told, quiet)]
    assert results[1] == results[0].replace("told", "quiet") != ""


def test_what_a_law_prints_is_no_part_of_the_result(tmp_path: Path) -> None:
    law = tmp_path / "mylaw.py"
    law.write_text("def talks(seen):\n    print('here')\n")
    asked = ("rehearse", "grove", "-n", "1", "--law", f"{law}:talks", "--json", "--out", tmp_path / "run")
    said = clew(*asked)
    assert json.loads(said.stdout)["no_route"]
    assert "here\n" in said.stderr
