"""Text from a log cannot control a terminal."""

import io
import logging
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from rich.console import Console

from agents.process.host import say
from clew.fleet.summary import summary_of
from clew.fleet.table_picture import picture
from clew.fleet.table_rows import Scoreboard
from clew.log.replay import Difference, Replay, Replayed, sentences
from protocol.plain import PlainFormatter, plain
from protocol.root import ROOT
from protocol.timeline import RobotFailed
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, HEADER, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

ESCAPED = "\\x1b[2J"
ORDERS = "\x1b[2J\x1b]0;pwn\x07\u202e[bold]r1"
IN_JSON = b"\\u001b[2J\\u001b]0;pwn\\u0007\\u202e[bold]r1"


def orders_in(said: str) -> list[str]:
    """The lines that would do more to a terminal than to be read."""
    return [line for line in said.split("\n") if not line.isprintable()]


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
def test_text_of_a_log_cannot_control_a_terminal(run: Path, tmp_path: Path, verb: str) -> None:
    other = recorded(tmp_path / "other", numbered(AT_REST[1:]))
    said = clew("log", verb, run, *([other] if verb == "diff" else []))
    assert said.exit_code in {0, 1}
    assert "\\x1b[2J" in said.stdout + said.stderr
    assert orders_in(said.stdout + said.stderr) == []


@pytest.mark.parametrize(
    "verb", [["report"], ["figures", "--format", "svg"], ["log", "export", "--to", "csv"]]
)
def test_flaws_of_a_log_cannot_control_a_terminal(run: Path, verb: list[str]) -> None:
    said = clew(*verb, run)
    assert ESCAPED in said.stderr
    assert orders_in(said.stdout + said.stderr) == []


def test_a_replay_cannot_control_a_terminal() -> None:
    apart = Difference(
        robot=1,
        incarnation=ORDERS,
        input=1,
        t_s=0.0,
        key=ORDERS,
        number=1,
        kind=ORDERS,
        event={"why": "\x9b2J"},
        recorded={"failed": "\x9b2J"},
        replayed=[],
    )
    one = Replayed(robot=1, incarnation="", decisions=1, flaws=(ORDERS,), damaged=False, difference=apart)
    said = list(sentences(Replay(ok=False, decisions=1, robots=(one,), missing=())))
    assert len(said) == 5
    assert orders_in("\n".join(said)) == []


def test_a_summary_cannot_control_a_terminal(run: Path) -> None:
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(msgspec.structs.replace(GOOD, reason=ORDERS)))
    said = summary_of(str(run))
    assert ESCAPED in said
    assert orders_in(said) == []


def test_a_live_table_cannot_control_a_terminal() -> None:
    console = Console(width=200, height=50, file=io.StringIO())
    board = Scoreboard.of(HEADER)
    for source, entry in numbered(
        (("world", RobotFailed(reason=ORDERS)), ("r1", RobotFailed(reason=ORDERS)))
    ):
        board.hear(source, entry)
    console.print(picture(board, None, (ORDERS,), height=50, width=200))
    said = console.file.getvalue()  # type: ignore[attr-defined] # it is the StringIO from above
    assert said.count(ESCAPED) == 3
    assert orders_in(said) == []


def test_stderr_of_world_and_robot_cannot_control_a_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    record = logging.LogRecord("world", logging.INFO, "", 0, "r1 has failed: %s", (ORDERS,), None)
    assert PlainFormatter("world: %(message)s").format(record) == f"world: r1 has failed: {plain(ORDERS)}"
    say(ORDERS)
    assert capsys.readouterr().err == f"{plain(ORDERS)}\n"


def test_a_refusal_cannot_control_a_terminal(run: Path) -> None:
    (run / EVENTS_FILE).write_bytes(b'{"kind":"run.started","schema":"%s"}\n' % IN_JSON)
    said = clew("log", "cat", run)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert said.stderr.strip().isprintable()


def test_printable_text_is_unchanged() -> None:
    assert plain("Zürich 5 m") == "Zürich 5 m"
    assert plain(ORDERS) == "\\x1b[2J\\x1b]0;pwn\\x07\\u202e[bold]r1"
    assert plain("one\ntwo") == "one\\ntwo"


@pytest.mark.processes
@pytest.mark.parametrize(
    "words", [("log", "cat", "RUN"), ("log", "info", "RUN"), ("judge", "RUN"), ("--help",)], ids=" ".join
)
def test_a_full_disk_is_one_line_and_exit_1(run: Path, words: tuple[str, ...]) -> None:
    command = [sys.executable, "-m", "clew.cli", *(str(run) if word == "RUN" else word for word in words)]
    with Path("/dev/full").open("wb") as full:
        said = subprocess.run(
            command, cwd=ROOT, stdout=full, stderr=subprocess.PIPE, timeout=DEADLINE_S, check=False
        )
    assert (said.returncode, said.stderr) == (1, b"Error: cannot write: No space left on device\n")
