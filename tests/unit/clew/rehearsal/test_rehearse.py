"""`clew rehearse`: writes a folder like a live run's; the same seed gives the same folder."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from itertools import chain, repeat
from pathlib import Path

import msgspec
import pytest

from agents.commands import Command
from agents.process.journal import Given, Journal, decided
from agents.robot import Robot
from clew.log import timeline
from clew.log.check import check
from clew.log.journals.recording import Recording
from clew.rehearsal import endless_law, rehearsal
from clew.rehearsal.recorded import Recorded, rehearse
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.plan import load as load_plan
from protocol.network.session import INPUTS
from protocol.root import ROOT
from protocol.timeline import kind_of
from tests.support.campaigns import clew, closed, scene
from tests.support.deadline import DEADLINE_S
from world.record.lines import Line
from world.record.run_files import read_verdict
from world.scenario.scenario import load


@pytest.fixture(autouse=True)
def somewhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Use a separate working folder, so that no test writes into the project's `runs/`."""
    monkeypatch.chdir(tmp_path)


def process(*arguments: str | Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "clew.cli", *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def kinds(lines: Sequence[Line]) -> set[str]:
    return {kind_of(entry.record) for _, entry in lines}


def test_the_header_contains_the_fault_plan_or_null(tmp_path: Path) -> None:
    field = scene(tmp_path / "posts.json")
    clew("rehearse", field, "-n", "1", "--out", tmp_path / "none")
    clew("rehearse", field, "-n", "1", "--faults", "loss-50", "--out", tmp_path / "lossy")
    none, lossy = (timeline.read(tmp_path / name).header.faults for name in ("none", "lossy"))
    assert none is None
    assert msgspec.convert(lossy, Plan) == load_plan("loss-50")


def test_the_folder_has_the_contents_of_a_live_run(tmp_path: Path) -> None:
    said = clew("rehearse", scene(tmp_path / "posts.json"))
    assert said.exit_code == 0, said.stderr
    latest = tmp_path / "runs" / "latest"
    last = said.stdout.splitlines()[-1]
    assert last.startswith("OK: every living robot has arrived; 5 of 5 robots arrived")
    assert last.endswith(f"Run: runs/{latest.resolve().name}")
    read = timeline.read(latest)
    assert read.flaws == ()
    assert {"robot.started", "robot.settled", "traffic.counted", "run.ended"} <= kinds(read.lines)
    finding, verdict = check(read), read_verdict(latest)
    assert finding.ok
    assert (finding.clearance_m_min, finding.path_m) == (verdict.clearance_m_min, verdict.path_m)
    assert verdict.messages.sent == verdict.messages.received > 100
    assert (verdict.messages.left_out, verdict.events.recorded) == ((), len(read.lines))
    assert read.lines[-1][1].t_s - verdict.sim_s < 0.2, "the run did not wait for any process at the end"


def test_time_stamps_of_a_source_follow_simulated_time_and_are_unique(tmp_path: Path) -> None:
    clew("rehearse", scene(tmp_path / "posts.json"), "--out", tmp_path / "run")
    stamps: dict[str, list[int]] = {}
    for source, entry in timeline.read(tmp_path / "run").lines:
        ntp64, by = entry.hlc.split("/")
        assert by == source
        assert int(ntp64) / 2**32 == pytest.approx(entry.t_s, abs=1e-6)
        stamps.setdefault(source, []).append(int(ntp64))
    assert len(stamps) == 6
    assert all(each == sorted(set(each)) for each in stamps.values())


def test_json_prints_the_verdict_and_nothing_else(tmp_path: Path) -> None:
    said = clew("rehearse", scene(tmp_path / "posts.json"), "-n", "2", "--out", tmp_path / "run", "--json")
    assert said.stdout == (tmp_path / "run" / "verdict.json").read_text(encoding="utf-8")
    assert (json.loads(said.stdout)["robots"], json.loads(said.stdout)["speed"]) == (2, None)
    assert not (tmp_path / "runs").exists(), "--out does not change runs/latest"


def test_a_failed_run_exits_1_with_its_reason(tmp_path: Path) -> None:
    said = clew("rehearse", closed(tmp_path / "closed.json"), "--out", tmp_path / "run")
    assert said.exit_code == 1
    assert "the leader lost its route" in said.stdout.splitlines()[-1]


@pytest.mark.parametrize(
    "wrong", [["nowhere"], ["paper", "-n", "0"], ["paper", "--law", "none"], ["paper", "--seed", "-1"]]
)
def test_invalid_arguments_exit_2_and_leave_no_folder(tmp_path: Path, wrong: list[str]) -> None:
    said = clew("rehearse", *wrong)
    assert (said.exit_code, said.stdout) == (2, "")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_a_run_is_refused(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    assert clew("rehearse", path, "--out", tmp_path / "run").exit_code == 0
    assert clew("rehearse", path, "--out", tmp_path / "run").exit_code == 2


@pytest.mark.parametrize(
    ("number", "code", "ended"),
    [
        (signal.SIGINT, 130, "interrupted"),
        (signal.SIGTERM, 143, "told to end"),
        (signal.SIGHUP, 129, "its terminal was closed"),
    ],
)
def test_a_signal_ends_the_run_with_a_verdict(
    tmp_path: Path, number: signal.Signals, code: int, ended: str
) -> None:
    far = scene(tmp_path / "far.json", goal=[900.0, 0.0], bounds=[0.0, -1.0, 1000.0, 1.0])
    run = process("rehearse", far, "--out", tmp_path / "run")
    assert run.stderr is not None
    while "plans step 1" not in (line := run.stderr.readline()):
        assert line, "the run ended before it planned a step"
    run.send_signal(number)
    run.communicate(timeout=DEADLINE_S)
    assert run.returncode == code
    assert timeline.read(tmp_path / "run").ended == ended
    assert read_verdict(tmp_path / "run").exit_code == code


def test_sigint_is_obeyed_between_two_deliveries_of_a_tick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With 200 robots a tick has hundreds of deliveries, and may take seconds."""
    handled = 0

    def interrupted_at_50(core: Robot, given: Given, now_s: float, journal: Journal) -> list[Command]:
        nonlocal handled
        handled += 1
        if handled == 50:
            signal.raise_signal(signal.SIGINT)
        return decided(core, given, now_s, journal)

    monkeypatch.setattr(rehearsal, "decided", interrupted_at_50)
    folder = tmp_path / "run"
    folder.mkdir()
    verdict = rehearse(load("paper", robots=200), 1, folder, lambda _: None)
    assert handled == 50
    assert (verdict.exit_code, timeline.read(folder).ended) == (ExitCode.INTERRUPTED, "interrupted")


def test_sigint_also_ends_a_run_whose_law_never_returns_and_says_whose_law_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(endless_law, "PATIENCE_S", 0.05)
    law = tmp_path / "mylaw.py"
    law.write_text(
        "import signal, time\n"
        "def mine(seen):\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    until_s = time.monotonic() + 60.0\n"
        "    while time.monotonic() < until_s: pass\n"
    )
    folder = tmp_path / "run"
    folder.mkdir()
    said: list[str] = []
    verdict = rehearse(load("grove", robots=2, law=f"{law}:mine"), 1, folder, said.append)
    assert (verdict.exit_code, timeline.read(folder).ended) == (ExitCode.INTERRUPTED, "interrupted")
    assert verdict.reason.startswith("the run was interrupted; the leader lost its route at t=")
    (lost,) = [line for line in said if "lost its route" in line]
    assert "r1 has lost its route: the law mylaw.py:mine@" in lost
    assert "it had not returned 0.05 s after the request to end" in lost


def test_a_rehearsal_waits_for_no_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "fdatasync", lambda _: pytest.fail("nobody resumes a rehearsal"))
    clew("rehearse", scene(tmp_path / "posts.json"), "-n", "2", "--out", tmp_path / "run")
    assert "fence.changed" in kinds(timeline.read(tmp_path / "run").lines)


def test_its_processor_time_begins_with_the_rehearsal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process may have rehearsed before."""
    spent_s = chain([100.0], repeat(102.5))
    monkeypatch.setattr("clew.rehearsal.recorded.time.process_time", lambda: next(spent_s))
    scenario = load(str(scene(tmp_path / "small.json")), robots=1)
    (tmp_path / "run").mkdir()
    assert rehearse(scenario, 1, tmp_path / "run", lambda _: None).cpu_s == 2.5
    assert read_verdict(tmp_path / "run").cpu_s == 2.5


def test_journals_of_a_rehearsal_that_fails_hold_all_that_was_decided(tmp_path: Path) -> None:
    grove, plan = load("grove"), load_plan("leader-killed")

    def fail(said: str) -> None:
        if "plans step 3" in said:
            raise ZeroDivisionError

    (tmp_path / "kept").mkdir()
    (tmp_path / "at once").mkdir()
    with pytest.raises(ZeroDivisionError):
        rehearse(grove, 0, tmp_path / "kept", fail, plan)
    with (
        pytest.raises(ZeroDivisionError),
        Recorded(grove, 0, tmp_path / "at once", plan, fail, keeps_bytes=0) as recorded,
    ):
        for _ in recorded.ticks():
            pass
    at_once = sorted((tmp_path / "at once" / INPUTS).iterdir())
    assert len(at_once) == 5
    for path in at_once:
        kept = Recording(tmp_path / "kept" / INPUTS / path.name)
        turns = list(Recording(path).turns())
        assert list(kept.turns()) == turns
        assert turns[-1].decision is not None
