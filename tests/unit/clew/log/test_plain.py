"""What a log says reaches a terminal as words, never as orders."""

import subprocess
import sys
from pathlib import Path

import pytest

from clew.log.plain import plain
from protocol.root import ROOT
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, numbered, recorded
from world.record.recorder import EVENTS_FILE

ORDERS = "\x1b[2J\x1b]0;pwn\x07\u202e[bold]r1"
IN_JSON = b"\\u001b[2J\\u001b]0;pwn\\u0007\\u202e[bold]r1"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A log that orders a terminal about wherever its writer may put words."""
    run = recorded(tmp_path / "run", numbered(AT_REST))
    path = run / EVENTS_FILE
    text = path.read_bytes().replace(b'"source":"world"', b'"source":"%s"' % IN_JSON)
    text = text.replace(b'"reason":"interrupted"', b'"reason":"%s"' % IN_JSON)
    text = text.replace(b'"clew":"0.1.0"', b'"%s":"%s"' % (IN_JSON, IN_JSON))
    first, second, *rest = text.splitlines(keepends=True)
    strange = second.replace(b"pose.sampled", IN_JSON)
    path.write_bytes(b"".join([first, *rest, second, strange, second]))
    return run


@pytest.mark.parametrize("verb", ["cat", "info", "check", "diff"])
def test_a_terminal_gets_no_order_from_a_log(run: Path, tmp_path: Path, verb: str) -> None:
    other = recorded(tmp_path / "other", numbered(AT_REST[1:]))
    said = clew("log", verb, run, *([other] if verb == "diff" else []))
    assert said.exit_code in {0, 1}
    assert "\\x1b[2J" in said.stdout + said.stderr
    assert [text for text in (said.stdout + said.stderr).split("\n") if not text.isprintable()] == []


def test_a_refusal_gives_no_order_either(run: Path) -> None:
    (run / EVENTS_FILE).write_bytes(b'{"kind":"run.started","schema":"%s"}\n' % IN_JSON)
    said = clew("log", "cat", run)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert said.stderr.strip().isprintable()


def test_what_prints_stays_as_it_is() -> None:
    assert plain("Zürich 5 m") == "Zürich 5 m"
    assert plain(ORDERS) == "\\x1b[2J\\x1b]0;pwn\\x07\\u202e[bold]r1"
    assert plain("one\ntwo") == "one\\ntwo"


@pytest.mark.processes
@pytest.mark.parametrize("verb", ["cat", "info"])
def test_a_full_disk_is_one_line_and_exit_1(run: Path, verb: str) -> None:
    command = [sys.executable, "-m", "clew.cli", "log", verb, str(run)]
    with Path("/dev/full").open("wb") as full:
        said = subprocess.run(
            command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, timeout=DEADLINE_S, check=False
        )
    assert (said.returncode, said.stderr) == (1, b"Error: cannot write: No space left on device\n")
