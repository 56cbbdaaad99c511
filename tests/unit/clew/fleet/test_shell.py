"""The supervisor's shell with toy parts of a few lines each: it executes what the core has decided."""

import asyncio
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

import pytest

from clew.fleet import shell
from clew.fleet.output import output
from clew.fleet.parts import processes
from clew.fleet.parts.command_lines import PARTS, Part, Stdout
from clew.fleet.prepare import Prepared, Shows
from clew.fleet.shell import supervise
from clew.fleet.supervision.events import HOST, WORLD, Command, Event, Ready, router_name
from clew.fleet.supervision.limits import Limits
from clew.fleet.supervisor import Supervisor
from protocol.exit_codes import ExitCode
from protocol.faults.manual_faults import WHERE_FILE
from protocol.faults.process_commands import PIPE
from protocol.run_settings import Settings
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import wait_until
from world.scenario.scenario import load

HELP = """
import os, pathlib, signal, sys, time
private = pathlib.Path(sys.argv[1])
def note(name, text=""):
    (private / "new").write_text(text)
    (private / "new").rename(private / name)
def wait_for(done):
    while not done():
        time.sleep(0.005)
"""
UNTIL_KILLED = "sys.stdin.read()"  # or until the test has ended: it holds the other end of the lifeline
ROUTER = f"note('router', str(os.getpid())); print('ready', flush=True); {UNTIL_KILLED}"


class Toys:
    """A fleet of toy parts, and the folder that they may write to."""

    def __init__(self, private: Path) -> None:
        self.private, self.folder = private, private / "run"
        self.folder.mkdir()
        self.lifeline, self.writing_end = os.pipe()

    def be(self, part: str, code: str, stdout: Stdout = Stdout.STDERR) -> None:
        """Let a part run this code."""
        cast("dict[str, Part]", PARTS)[part] = Part(
            lambda _: ["-ISc", HELP + code, str(self.private)], stdout
        )

    def run(self, *asked: ExitCode) -> int:
        """Supervise them; returns the exit code."""

        def hear(tell: Callable[[ExitCode], None]) -> None:
            for code in asked:
                tell(code)

        run = Prepared(
            private=self.private,
            folder=self.folder,
            made=(),
            latest=None,
            scenario=load("grove", robots=1),
            settings=Settings(seed=1),
            started_at="2026-11-20T00:00:00+00:00",
            own_routers=1,
            as_json=False,
            view=False,
            shows=Shows.LINES,
        )
        with processes.orphans_adopted(), output(run) as words:
            supervised = supervise(run, self.lifeline, words, hear)
            return asyncio.run(asyncio.wait_for(supervised, DEADLINE_S))

    def noted(self, name: str) -> int:
        """The process id that a toy part has written to a file."""
        return int((self.private / name).read_text())


@pytest.fixture
def toys(monkeypatch: pytest.MonkeyPatch) -> Iterator[Toys]:
    for part, usual in PARTS.items():
        monkeypatch.setitem(cast("dict[str, Part]", PARTS), part, usual)  # monkeypatch restores it
    # Python warns of a process that nobody has waited for, in whichever test is running then.
    monkeypatch.setattr(processes, "KILLED_S_MAX", DEADLINE_S)
    with TemporaryDirectory(prefix="ct.", dir="/tmp") as private:
        toys = Toys(Path(private))
        toys.be(router_name(1), ROUTER, Stdout.READY)
        toys.be(HOST, UNTIL_KILLED)
        yield toys
        os.close(toys.lifeline)
        os.close(toys.writing_end)


def wait_for_the_end_of(pid: int) -> None:
    """Wait until a killed process has ended: a busy machine takes longer than the supervisor waits."""
    wait_until(lambda: not is_there(pid) or None)


def is_there(pid: int) -> bool:
    """Whether a process lives; a zombie does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][0] != "Z"
    except FileNotFoundError:
        return False


def test_run_ends_with_its_world_and_leaves_nothing(toys: Toys) -> None:
    toys.be(WORLD, "sys.exit(7)")
    assert toys.run() == 7
    wait_for_the_end_of(toys.noted("router"))


def test_a_run_goes_on_if_nobody_can_be_told_which_router_carries_it(
    toys: Toys, capfd: pytest.CaptureFixture[str]
) -> None:
    (toys.private / "router.pid").mkdir()  # as on a full disk, it cannot be written
    toys.be(WORLD, "sys.exit(7)")
    assert toys.run() == 7
    assert "nobody is told that router 1 carries the fleet: Is a directory" in capfd.readouterr().err


def test_where_manual_faults_are_taken_does_not_outlive_a_world_that_was_killed(toys: Toys) -> None:
    toys.be(WORLD, f"(private / 'run' / '{WHERE_FILE}').write_text('socket'); os.kill(os.getpid(), 9)")
    toys.run()
    assert list(toys.folder.iterdir()) == []


def test_each_part_has_its_own_process_group_and_the_lifeline_as_stdin(toys: Toys) -> None:
    lifeline = os.fstat(toys.lifeline).st_ino
    toys.be(WORLD, f"sys.exit(3 if (os.getpgrp(), os.fstat(0).st_ino) == (os.getpid(), {lifeline}) else 4)")
    assert toys.run() == 3


def test_process_fault_from_the_pipe_is_executed_and_process_ids_stay_current(
    toys: Toys, capfd: pytest.CaptureFixture[str]
) -> None:
    read = "lambda: (private / 'router.pid').read_text().strip()"
    toys.be(
        WORLD,
        f"""
read = {read}
before = read()
with (private / "{PIPE}").open("w") as pipe:
    pipe.write("nonsense\\nfreeze nobody\\nkill router\\n")
wait_for(lambda: (private / "router").read_text() != before)
sys.exit(5 if read() == (private / "router").read_text() else 6)
""",
    )
    assert toys.run() == 5
    assert "clew: router 1 was killed by SIGKILL; it is started again\n" in capfd.readouterr().err


def test_leftovers_in_a_hosts_group_are_found_and_killed(
    toys: Toys, capfd: pytest.CaptureFixture[str]
) -> None:
    toys.be(
        HOST,
        f"""
if os.fork():
    wait_for((private / "child").exists)
    sys.exit(0)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
note("child", str(os.getpid()))
{UNTIL_KILLED}
""",
    )
    toys.be(WORLD, "wait_for((private / 'child').exists)")
    assert toys.run() == 0
    named = r"^clew: the host had not ended \d+\.\d s after it was asked to, and was killed$"
    assert re.search(named, capfd.readouterr().err, re.MULTILINE)
    wait_for_the_end_of(toys.noted("child"))


def test_leftovers_in_a_hosts_group_that_end_on_request_are_not_killed(
    toys: Toys, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    toys.be(
        HOST,
        f"""
if os.fork():
    wait_for((private / "child").exists)
    sys.exit(0)
def end(*_):
    time.sleep(0.05)  # so that the router ends first
    sys.exit(0)
signal.signal(signal.SIGTERM, end)
note("child", str(os.getpid()))
{UNTIL_KILLED}
""",
    )
    toys.be(WORLD, "wait_for((private / 'child').exists)")
    patient = Limits(others_s=DEADLINE_S, all_s=2 * DEADLINE_S)
    monkeypatch.setattr(shell, "limits_of", lambda *_, **__: patient)
    assert toys.run() == 0
    assert "had not ended" not in capfd.readouterr().err
    assert not is_there(toys.noted("child"))


def test_run_that_is_asked_to_end_before_it_begins_starts_nothing(toys: Toys) -> None:
    assert toys.run(ExitCode.INTERRUPTED) == 130
    assert not (toys.private / "router-1.pid").exists()


def test_part_that_cannot_be_started_is_named_and_ends_the_run(
    toys: Toys, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(processes, "command_of", lambda *_, **__: ["/nowhere/python"])
    assert toys.run() == 1
    said = capfd.readouterr().err
    assert "clew: router 1 cannot be started: No such file or directory\n" in said
    assert "clew: router 1 ended with exit code 1 before it was ready\n" in said


def test_internal_error_ends_us_and_leaves_nothing(toys: Toys, monkeypatch: pytest.MonkeyPatch) -> None:
    handle = Supervisor.handle

    def mistaken(supervisor: Supervisor, event: Event, now_s: float) -> list[Command]:
        assert not isinstance(event, Ready), "a mistake"
        return handle(supervisor, event, now_s)

    monkeypatch.setattr(Supervisor, "handle", mistaken)
    with pytest.raises(AssertionError, match="a mistake"):
        toys.run()
    wait_for_the_end_of(toys.noted("router"))
