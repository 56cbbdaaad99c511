"""A verb whose standard streams its caller has closed runs as if they were /dev/null."""

import subprocess
import sys
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, numbered, recorded

WHERE = "import os, sys; sys.exit(repr([os.readlink(f'/proc/self/fd/{each}') for each in range(3)]))"


def closing(streams: str, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a program in Python without these standard streams, in the words of the shell."""
    command = ["bash", "-c", f'exec "$@" {streams}', "bash", sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=DEADLINE_S, check=False)


@pytest.mark.processes
@pytest.mark.parametrize(
    "words", [("log", "cat", "RUN"), ("log", "diff", "RUN", "RUN"), ("ls", "RUN/..")], ids=" ".join
)
def test_a_verb_whose_stdout_is_closed_says_nothing(tmp_path: Path, words: tuple[str, ...]) -> None:
    run = recorded(tmp_path / "run", numbered(AT_REST))
    said = closing(">&-", "-m", "clew.cli", *(each.replace("RUN", str(run)) for each in words))
    assert (said.returncode, said.stdout) == (0, "")
    assert "Traceback" not in said.stderr


@pytest.mark.processes
def test_no_other_file_gets_the_number_of_a_closed_stream_and_children_inherit_what_does() -> None:
    opened = "from protocol.process.streams import open_streams; open_streams(); "
    child = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {WHERE!r}])"
    said = closing("<&- >&-", "-c", opened + child)
    assert said.stderr.startswith("['/dev/null', '/dev/null', 'pipe:"), said.stderr
