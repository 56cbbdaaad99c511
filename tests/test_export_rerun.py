"""Rerun's RRD, where Rerun is installed; what is said where it is not."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.campaigns import clew
from tests.exports import lively


@pytest.mark.skipif(find_spec("rerun") is None, reason="rerun is not installed: 700 MB, the extra `rerun`")
def test_rerun_reads_back_where_robots_were(tmp_path: Path) -> None:
    import rerun as rr  # noqa: PLC0415 - only where it is installed

    run = lively(tmp_path / "run")
    said = clew("log", "export", run, "--to", "rrd")
    assert said.stdout.strip() == str(run / "events.rrd")
    assert (run / "events.rrd").read_bytes().startswith(b"RRF2")
    assert rr.__version__


@pytest.mark.skipif(find_spec("rerun") is not None, reason="rerun is installed")
def test_where_rerun_is_missing_the_extra_is_named(tmp_path: Path) -> None:
    said = clew("log", "export", lively(tmp_path / "run"), "--to", "rrd")
    assert said.exit_code == 2
    assert said.stderr == "Error: this export needs rerun, the extra `rerun`: pip install '.[rerun]'\n"
