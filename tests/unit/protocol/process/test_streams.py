"""A verb whose standard streams its caller has closed, or nobody reads, runs as if they were /dev/null."""

import os
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
    "words", [("log", "cat", "RUN"), ("log", "diff", "RUN", "RUN"), ("ls", "RUN")], ids=" ".join
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


@pytest.mark.processes
@pytest.mark.parametrize(
    ("words", "stderr", "code"),
    [
        ("--help", "read", 0),
        ("log cat RUN", "read", 0),
        ("log messages RUN", "unread", 0),
        ("ls RUN", "read", 0),
        ("log diff RUN OTHER", "read", 1),
        ("log cat nowhere", "unread", 2),
    ],
)
def test_a_verb_whose_reader_has_gone_exits_as_if_it_were_read(
    tmp_path: Path, words: str, stderr: str, code: int
) -> None:
    run, other = recorded(tmp_path / "run", numbered(AT_REST)), recorded(tmp_path / "other", [])
    said = words.replace("RUN", str(run)).replace("OTHER", str(other)).split()
    reader, writer = os.pipe()
    os.close(reader)
    ended = subprocess.run(
        [sys.executable, "-m", "clew.cli", *said],
        stdout=writer,
        stderr=writer if stderr == "unread" else subprocess.PIPE,
        cwd=ROOT,
        timeout=DEADLINE_S,
        check=False,
    )
    os.close(writer)
    assert ended.returncode == code
    assert b"Broken pipe" not in (ended.stderr or b"")
