"""Ctrl-C at any moment of a start ends a program with 130, and without a traceback.

A real process interrupts itself just as it imports a module: from outside nobody can be sure to be in time.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

# Python imports this file at its start, when it has a handler for SIGINT. The processes of a run do so, too.
STRIKES = """
import os, signal, sys
def strike():
    os.kill(os.getpid(), signal.SIGINT)
def hear(event, args, moment=os.environ.pop("MOMENT", "")):
    global strike
    if event == "import" and args[0] == moment:
        strike, now = lambda: None, strike
        now()
sys.addaudithook(hear)
import colorsys
"""
PROGRAM = (sys.executable, "-m", "clew.cli")
SCRIPT = (str(ROOT / "launch" / "fleet.sh"),)
OURS = (
    "protocol.process.streams",
    "click",
    "clew.verbs.group",
    "clew.fleet.request",
    "clew.fleet.shell",
)
BEFORE = ("colorsys", "runpy", "clew", "protocol.process.loading")
"""While Python starts, and before our first line."""


@pytest.mark.parametrize(
    ("command", "moment"),
    [*(((*PROGRAM, "run"), moment) for moment in OURS), *((SCRIPT, moment) for moment in (*BEFORE, *OURS))],
    ids=lambda each: each if isinstance(each, str) else Path(each[0]).name,
)
def test_ctrl_c_while_a_run_starts_ends_it_with_130_and_no_traceback(
    tmp_path: Path, command: tuple[str, ...], moment: str
) -> None:
    (tmp_path / "sitecustomize.py").write_text(STRIKES)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    said = subprocess.run(
        [*command, "grove", "-n", "2", "--quiet", "--out", str(tmp_path / "run")],
        env=os.environ | {"PYTHONPATH": path, "MOMENT": moment, "TMPDIR": "/tmp"},
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )
    assert said.returncode == 130
    assert "Traceback" not in said.stderr
    assert "Aborted" not in said.stderr
