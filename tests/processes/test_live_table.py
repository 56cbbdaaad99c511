"""The live table of real fleets on a pseudo-terminal: what it shows, and that it restores the terminal."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from protocol.faults.manual_faults import FaultRequest, request_fault
from protocol.faults.rules import Kill
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, numbered, recorded
from tests.support.processes.fleets import Fleet, wait_until
from tests.support.processes.terminals import CTRL_C, Terminal
from world.record.recorder import EVENTS_FILE, line

ROW = re.compile(r" *r\d+ .* (?P<driven>\d+\.\d+) m +(?P<way>\d+)% +\d+\.\d+ m +(?P<least>\d+\.\d+) m")


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    terminal = Terminal()
    yield terminal
    terminal.close()


def begin(fleet: Fleet, terminal: Terminal, *arguments: str) -> None:
    """Start a fleet as a user at this terminal would."""
    fleet.start_on(terminal.theirs, *arguments, TERM="xterm-256color")
    terminal.begin()


def code_of(fleet: Fleet, terminal: Terminal) -> int:
    """The exit code, after all output has been read."""
    terminal.read_to_the_end()
    assert fleet.launcher is not None
    return fleet.launcher.wait(DEADLINE_S)


def test_table_follows_the_fleet_and_ends_with_the_verdicts_numbers(fleet: Fleet, terminal: Terminal) -> None:
    begin(fleet, terminal, "grove", "-n", "3", "--seed", "1", "--speed", "2")
    assert "r1  leader  leading" in terminal.wait_for("leading")
    assert terminal.hides_its_cursor()
    # It leads until this has been seen.
    request_fault(fleet.folder(), FaultRequest(rule=Kill(target="leader")))
    terminal.wait_for("r2  leader  leading")
    terminal.wait_for("r1          dead")
    assert code_of(fleet, terminal) == 0
    verdict, lines = fleet.verdict(), terminal.text.splitlines()
    rows = [row for row in map(ROW.match, lines) if row is not None]
    assert len([line for line in lines if " arrived " in line and ROW.match(line)]) == 2
    assert sum(float(row["driven"]) for row in rows) == pytest.approx(verdict["path_m"], abs=0.03)
    assert min(float(row["least"]) for row in rows) == pytest.approx(verdict["clearance_m_min"], abs=5e-4)
    assert "OK: every living robot has arrived" in lines
    assert "Run:runs/" in "".join(terminal.text.split())  # the line may wrap anywhere
    assert not terminal.hides_its_cursor()
    assert fleet.leftovers() == []


def test_ctrl_c_ends_the_run_and_the_parts_output_stays_on_the_screen(
    fleet: Fleet, terminal: Terminal
) -> None:
    begin(fleet, terminal, "grove", "-n", "2", "--seed", "1")
    terminal.wait_for("leading")
    os.kill(fleet.process("protocol"), signal.SIGKILL)
    words = "clew: router 1 was killed by SIGKILL; it is started again"
    terminal.wait_for(words)
    table = terminal.wait_for("seed 1")  # it is drawn again below the words, and a read may end in between
    assert table.index(words) < table.index("seed 1")
    terminal.press(CTRL_C)
    assert code_of(fleet, terminal) == 130
    assert "FAILED: the run was interrupted" in terminal.text
    assert terminal.text.index("seed 1") < terminal.text.index(words) < terminal.text.index("switching steps")
    assert "world: t=" not in terminal.text
    assert not terminal.hides_its_cursor()
    assert fleet.leftovers() == []


def test_killed_launcher_leaves_nothing_behind_even_if_the_world_is_frozen(
    fleet: Fleet, terminal: Terminal
) -> None:
    begin(fleet, terminal, "paper", "-n", "2")
    terminal.wait_for("leading")
    os.kill(fleet.process("world"), signal.SIGSTOP)
    assert fleet.launcher is not None
    fleet.launcher.kill()
    terminal.read_to_the_end()
    assert not terminal.hides_its_cursor()
    wait_until(lambda: None if fleet.leftovers() else True)


def test_table_ends_with_its_lifeline_and_first_draws_everything_recorded(
    tmp_path: Path, terminal: Terminal
) -> None:
    run, said = recorded(tmp_path / "run", numbered(AT_REST[:-1])), tmp_path / "said"
    said.touch()
    ours = {**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm"}
    command = [sys.executable, "-m", "clew.fleet.table", str(run), "--said", str(said)]
    with subprocess.Popen(command, env=ours, stdin=subprocess.PIPE, stderr=terminal.theirs) as table:
        terminal.begin()
        terminal.wait_for("no promise broken so far")
        with (run / EVENTS_FILE).open("ab") as log:
            log.write(line("world", numbered(AT_REST)[-1][1]))
        assert table.stdin is not None
        table.stdin.close()
        try:
            terminal.read_to_the_end()
            assert table.wait(DEADLINE_S) == 0
        finally:
            table.kill()
    assert "over: interrupted" in terminal.text
    assert not terminal.hides_its_cursor()


def test_quiet_fleet_prints_nothing_before_its_report(fleet: Fleet) -> None:
    outcome = fleet.run("paper", "-n", "2", "--speed", "max", "--quiet")
    assert (outcome.code, outcome.err) == (0, "")
    assert "OK: every living robot has arrived" in outcome.out
