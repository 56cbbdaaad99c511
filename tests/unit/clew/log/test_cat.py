"""`clew log cat`: colours, filters, following, and pipes that close."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from clew.cli import main
from clew.log.line import COLOURS, is_coloured
from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.root import ROOT
from protocol.timeline import KINDS, FaultInjected, RobotReleased, ScanServed, StepPlanned
from protocol.timeline.steps import SeenObstacle
from tests.support.deadline import DEADLINE_S
from tests.support.logs.living import reachable_world
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from tests.support.processes.terminals import Terminal
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE, line
from world.record.run_files import save_verdict

ESCAPE = "\x1b["
FAULT = ("world", FaultInjected(fault="kill", rule="kill-1", process="r1"))


def clew(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["log", "cat", *map(str, arguments)])


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return recorded(tmp_path / "run", numbered((FAULT, *AT_REST)))


@pytest.fixture
def follower(tmp_path: Path) -> Iterator["subprocess.Popen[str]"]:
    """`clew log cat --follow` of a run that is not there yet."""
    command = [sys.executable, "-m", "clew.cli", "log", "cat", "run", "--follow"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.kill()


def environment() -> dict[str, str]:
    return {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "TERM": "xterm"}


def next_line(process: "subprocess.Popen[str]") -> str:
    """What it says next, or nothing where it says nothing in time."""
    assert process.stdout is not None
    late = threading.Timer(DEADLINE_S, process.kill)
    late.start()
    said = process.stdout.readline()
    late.cancel()
    return said


def test_every_kind_has_a_colour() -> None:
    families = {each.partition(".")[0] for each in KINDS}
    assert families == set(COLOURS)


def test_colours_are_printed_on_terminals_and_on_request(run: Path) -> None:
    assert ESCAPE not in clew(run).stdout
    assert ESCAPE in clew(run, "--color", "always").stdout
    assert ESCAPE not in clew(run, "--color", "always", "--json").stdout


@pytest.mark.parametrize(
    ("when", "variables", "coloured"),
    [
        ("auto", {"TERM": "xterm"}, True),
        ("auto", {"TERM": "xterm", "NO_COLOR": "1"}, False),
        ("auto", {"TERM": "dumb"}, False),
        ("never", {"TERM": "xterm"}, False),
        ("always", {"TERM": "dumb", "NO_COLOR": "1"}, True),
    ],
)
def test_the_environment_can_switch_colours_off(
    monkeypatch: pytest.MonkeyPatch, when: str, variables: dict[str, str], coloured: bool
) -> None:
    monkeypatch.setattr(os, "environ", variables)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    assert is_coloured(when) == coloured


@pytest.mark.parametrize(("more", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_a_terminal_gets_colours_unless_they_are_switched_off(
    run: Path, more: dict[str, str], coloured: bool
) -> None:
    terminal = Terminal()
    command = [sys.executable, "-m", "clew.cli", "log", "cat", str(run)]
    with subprocess.Popen(command, env=environment() | more, stdout=terminal.theirs):
        terminal.begin()
        terminal.read_to_the_end()
    terminal.close()
    assert (ESCAPE.encode() in terminal.written) == coloured
    assert "run.ended" in terminal.text


def test_without_leaves_out_kinds(run: Path) -> None:
    said = clew(run, "--without", "pose.*", "--without", "run.ended").stdout
    assert [line.split()[2] for line in said.splitlines()] == ["fault.injected"]


def test_long_lists_are_counted_for_people_and_complete_in_json(tmp_path: Path) -> None:
    scan = ScanServed(
        robot=1, x_m=0.0, y_m=0.0, heading_rad=0.0, revolutions=1, hits=0, ranges_m=(4.0,) * 360
    )
    run = recorded(tmp_path / "scanned", numbered((("world", scan),)))
    assert "ranges_m=[360 items]" in clew(run, "--fields").stdout
    assert clew(run, "--json").stdout.count("4.0") == 360


def test_a_step_is_one_readable_line_and_complete_in_json(tmp_path: Path) -> None:
    seen = SeenObstacle(tangent_1=Point(x_m=1 / 3, y_m=0.0), tangent_2=Point(x_m=1.0, y_m=0.0), chord_m=2 / 3)
    plan = StepPlanned(
        step=1, epoch=1, law="certified", x_m=2.231900877152494, y_m=1e-7, obstacles=(seen,) * 12, gaps=(),
        gap=None, heading_rad=0.0, length_m=1.0, target=Point(x_m=2 / 3, y_m=0.0), reach_m=1.0,
        promised_clearance_m=0.1, cost_to_go_m=None,
    )  # fmt: skip
    run = recorded(tmp_path / "planned", numbered((("r1", plan),)))
    said = clew(run, "--fields").stdout
    assert "x_m=2.2319 y_m=1e-7 obstacles=[12 items] gaps=[]" in said
    assert 'target={"x_m":0.6667,"y_m":0.0}' in said
    assert "2.231900877152494" in clew(run, "--json").stdout
    assert (
        clew(run).stdout == "    0.000     r1 step.planned       r1 plans step 1: 1.000 m, promises 0.100 m\n"
    )


@pytest.mark.parametrize(
    ("choice", "said"),
    [
        (
            ("--kind", "pose.sampeld"),
            "no entry matches; there is no kind 'pose.sampeld'; did you mean 'pose.sampled'",
        ),
        (("--robot", "77"), "no entry matches; robot: must be a robot of the fleet, r1 to r5, got 77"),
        (("--source", "wrld"), "no entry matches; source: must be world, or a robot of the fleet, r1 to r5"),
        (("--rule", "kil-1"), "no entry matches; rule: must be one of kill-1, got 'kil-1'; did you mean"),
        (("--key", "lnk/r1/r2"), "no entry matches; key: must be a key of messages in this run, such as"),
        (("--from", "9", "--to", "3"), "no entry matches; time: must be from an earlier time to a later one"),
        (("--step", "-1"), "no entry matches; step: must be an integer, 0 or more, got -1"),
        (("--kind", "step.*"), "no entry matches"),
    ],
)
def test_a_choice_without_a_match_is_reported_and_refused_if_the_run_cannot_have_it(
    run: Path, choice: tuple[str, ...], said: str
) -> None:
    told = clew(run, *choice)
    assert told.stdout == ""
    assert told.stderr.splitlines()[-1].removeprefix("Error: ").startswith(said)
    assert told.exit_code == (ExitCode.USAGE if "; " in said else ExitCode.OK)
    assert ("there is no kind" in told.stderr) == ("there is no kind" in said)


def test_a_robot_may_be_named_as_the_log_names_it(run: Path) -> None:
    assert clew(run, "--robot", "r2").stdout == clew(run, "--robot", "2").stdout != ""
    refused = clew(run, "--robot", "leader")
    assert refused.exit_code == 2
    assert "'--robot': must be a robot, as 3 or r3, got 'leader'" in refused.stderr


def test_a_pipe_gets_many_lines_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = recorded(tmp_path / "long", numbered([("r1", RobotReleased())] * 2500))
    counts: list[int] = []
    monkeypatch.setattr(click, "echo", lambda text, **_: counts.append(text.count("\n") + 1))
    clew(run, "--source", "r1")
    assert counts[:3] == [1000, 1000, 500]


def test_a_reader_that_closes_the_pipe_is_no_error(tmp_path: Path) -> None:
    many = [("r1", RobotReleased())] * 20_000  # more than any pipe holds
    run = recorded(tmp_path / "long", numbered(many))
    command = [sys.executable, "-m", "clew.cli", "log", "cat", str(run)]
    with subprocess.Popen(
        command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(DEADLINE_S) == 0


def test_follow_waits_for_the_run_prints_new_entries_and_ends_with_it(
    tmp_path: Path, follower: "subprocess.Popen[str]"
) -> None:
    text = (recorded(tmp_path / "elsewhere", numbered((FAULT, *AT_REST))) / EVENTS_FILE).read_bytes()
    header, fault, *rest = text.splitlines(keepends=True)
    (tmp_path / "run").mkdir()
    log = tmp_path / "run" / EVENTS_FILE
    with reachable_world(tmp_path / "run"):
        log.write_bytes(header + fault + rest[0][:-5])
        assert "fault.injected" in next_line(follower)
        with log.open("ab") as file:
            file.write(rest[0][-5:])
        assert "pose.sampled" in next_line(follower)
        with log.open("ab") as file:
            file.write(b"".join(rest[1:]))
        save_verdict(GOOD, tmp_path / "run")
        out, err = follower.communicate(timeout=DEADLINE_S)
    assert out.count("\n") == len(rest) - 1
    assert err == ""
    assert follower.returncode == 0


def test_follow_ends_when_its_reader_has_gone(tmp_path: Path, follower: "subprocess.Popen[str]") -> None:
    with reachable_world(recorded(tmp_path / "run", numbered((FAULT,)))):
        assert "fault.injected" in next_line(follower)
        assert follower.stdout is not None
        follower.stdout.close()
        with (tmp_path / "run" / EVENTS_FILE).open("ab") as file:
            file.write(b"".join(line(source, entry) for source, entry in numbered((FAULT, FAULT))[1:]))
        assert follower.wait(DEADLINE_S) == 0


def test_follow_ends_at_ctrl_c_with_130(tmp_path: Path, follower: "subprocess.Popen[str]") -> None:
    with reachable_world(recorded(tmp_path / "run", numbered((FAULT,)))):
        assert "fault.injected" in next_line(follower)
        follower.send_signal(signal.SIGINT)
        _, err = follower.communicate(timeout=DEADLINE_S)
    assert follower.returncode == 130
    assert err == ""


def test_follow_of_an_ended_run_reports_a_torn_line(run: Path) -> None:
    with (run / EVENTS_FILE).open("ab") as file:
        file.write(b'{"t_s":1')
    (run / VERDICT_FILE).write_bytes(b"{}")
    said = clew(run, "--follow", "--kind", "run.ended")
    assert said.stdout.count("\n") == 1
    assert "torn" in said.stderr
    assert said.exit_code == 0
