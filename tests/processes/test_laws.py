"""Live robots whose law is not there, as on another computer, or does not return."""

import os
import signal
from contextlib import ExitStack
from pathlib import Path

import pytest

from clew.log.timeline import read
from protocol import laws
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS
from protocol.root import ROOT
from protocol.run_settings import Settings
from protocol.timeline import RobotFailed, StrandFormed
from tests.support.deadline import DEADLINE_S
from tests.support.installed import install
from tests.support.processes.fleets import Fleet
from tests.support.processes.wire import python, router, session_folder
from world.record.run_files import prepare_folder, read_verdict
from world.scenario.scenario import load

ROOMY = ROOT / "docs" / "examples" / "roomy"


@pytest.mark.parametrize(
    "lacks",
    [pytest.param(2, id="a follower"), pytest.param(1, id="the first to lead", marks=pytest.mark.long)],
)
def test_a_robot_without_the_law_refuses_in_one_line_and_the_others_go_on_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lacks: int
) -> None:
    packages, run = tmp_path / "packages", tmp_path / "run"
    install(packages, "roomy", {"roomy": "roomy:roomy"})
    run.mkdir()
    for each in (packages, ROOMY):
        monkeypatch.syspath_prepend(each)
    monkeypatch.setattr(laws, "_loaded", {})
    prepare_folder(run, load("grove", robots=3, law="roomy"), NO_FAULTS, Settings(seed=1, speed=None))
    others = [robot for robot in (1, 2, 3) if robot != lacks]
    with session_folder() as folder, router(folder), ExitStack() as stack:

        def robots(those: str) -> tuple[str, ...]:
            return "-m", "agents", "--robots", those, "--sessions", str(folder)

        without = stack.enter_context(python(*robots(str(lacks))))
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, (packages, ROOMY, ROOT))))
        world = stack.enter_context(python("-m", "world", str(run), "--session", str(folder / "world.json")))
        host = stack.enter_context(python(*robots(",".join(map(str, others)))))
        ends = [process.communicate(timeout=DEADLINE_S)[1] for process in (world, without, host)]
    assert [process.returncode for process in (world, without, host)] == [
        ExitCode.FAILED,
        ExitCode.USAGE,
        ExitCode.OK,
    ]
    refused = "the law must be one of certified, printed, resultant, got 'roomy'"
    assert ends[1].startswith(f"robot {lacks}: {refused} (laws installed for ")
    assert ends[1].count("\n") == 1
    records = [entry.record for _, entry in read(run).lines]
    [failed] = [each for each in records if isinstance(each, RobotFailed)]
    assert failed.reason.startswith(f"it refuses the mission: {refused}")
    formed = [each.order for each in records if isinstance(each, StrandFormed)]
    assert all({*order} <= {*others} for order in formed)
    assert sorted(formed[-1]) == others, "a robot behind its body comes after the first has gone on"
    verdict = read_verdict(run)
    assert verdict.reason.startswith(
        f"P6 (no failed core) broken by robot {lacks} at t=0.0 s: it refuses the"
    )
    assert (verdict.robots_arrived, verdict.violations) == (2, 1)


def test_a_law_that_never_returns_is_named_with_its_line_while_the_run_goes_on(fleet: Fleet) -> None:
    (fleet.cwd / "mine.py").write_text("def endless(seen):\n    while True:\n        pass\n")
    launcher = fleet.start("grove", "-n", "1", "--law", "mine.py:endless")
    stalled = fleet.wait_for("law.stalled")
    assert stalled["law"].startswith("mine.py:endless@")
    assert (stalled["source"], stalled["at"] in {"mine.py:2", "mine.py:3"}) == ("r1", True)
    launcher.send_signal(signal.SIGINT)
    outcome = fleet.end()
    assert outcome.code == 130
    assert "r1 waits for the law mine.py:endless@" in outcome.err
    assert fleet.leftovers() == []
