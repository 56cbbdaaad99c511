"""Rerun's RRD, where Rerun is installed; what is said where it is not."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from clew.verbs.extras import install_line
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.runs import Runs


@pytest.mark.skipif(find_spec("rerun") is None, reason="rerun is not installed: 700 MB, the extra `rerun`")
def test_rerun_itself_finds_the_file_sound(runs: Runs, tmp_path: Path) -> None:
    run = runs.copy(tmp_path / "run", "grove", faults="leader-killed")
    said = clew("log", "export", run, "--to", "rrd")
    assert said.stdout.strip() == str(run / "events.rrd")
    verify = [sys.executable, "-m", "rerun", "rrd", "verify", str(run / "events.rrd")]
    assert subprocess.run(verify, check=False, timeout=DEADLINE_S).returncode == 0
    for name in (b"/world/robot/5", b"/world/scan/5", b"/world/links/lines", b"/events/robot.died"):
        assert name in (run / "events.rrd").read_bytes()


@pytest.mark.skipif(find_spec("rerun") is not None, reason="rerun is installed")
def test_where_rerun_is_missing_the_extra_is_named(runs: Runs) -> None:
    said = clew("log", "export", runs.of("grove"), "--to", "rrd")
    assert said.exit_code == 2
    assert said.stderr == f"Error: this export needs rerun, the extra `rerun`: {install_line('rerun')}\n"
