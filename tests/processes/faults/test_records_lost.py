"""Runs that lose their folder, their timeline, or world and host together: each ends soon, and says why."""

import json
import os
import shutil
import signal
import time

import pytest

from tests.support.processes.fleets import Fleet

SOON_S = 60.0  # it is noticed in 1 s, and the launcher promises 5 s from then: a slow machine takes longer


def begun(fleet: Fleet, *arguments: str) -> None:
    """Start a fleet and wait until its strand has formed."""
    fleet.start("grove", "-n", "2", *arguments)
    fleet.wait_for("strand.formed")


def test_a_run_whose_folder_is_removed_ends_within_seconds_with_one_line(fleet: Fleet) -> None:
    begun(fleet, "--json")
    folder = fleet.folder()
    removed_s = time.monotonic()
    shutil.rmtree(folder)
    ended = fleet.end()
    assert time.monotonic() - removed_s < SOON_S
    assert ended.code == 1
    said = [line for line in ended.err.splitlines() if "was removed: the run has no record" in line]
    assert len(said) == 1
    assert json.loads(ended.out)["reason"] == "the run's folder was removed"
    assert not folder.exists()
    assert fleet.leftovers() == []


def test_a_world_that_is_started_again_without_its_timeline_ends_the_run(fleet: Fleet) -> None:
    begun(fleet)
    world = fleet.process("world")
    os.kill(world, signal.SIGSTOP)  # so that it does not notice by itself
    (fleet.folder() / "events.jsonl").unlink()
    os.kill(world, signal.SIGKILL)
    ended = fleet.end()
    assert ended.code == 1
    said = [line for line in ended.err.splitlines() if "a run cannot go on without it" in line]
    assert len(said) == 1
    assert not (fleet.folder() / "events.jsonl").exists()
    assert fleet.verdict()["ok"] is False
    assert fleet.leftovers() == []


@pytest.mark.parametrize("first", ["world", "agents"])
def test_a_run_whose_host_and_world_die_together_has_a_failed_verdict(fleet: Fleet, first: str) -> None:
    begun(fleet, "--json")
    parts = [first, *({"world", "agents"} - {first})]
    launcher = fleet.launcher
    assert launcher is not None
    os.kill(launcher.pid, signal.SIGSTOP)  # it learns of both deaths at once
    for part in parts:
        os.kill(fleet.process(part), signal.SIGKILL)
    os.kill(launcher.pid, signal.SIGCONT)
    ended = fleet.end()
    assert ended.code == 1
    verdict = fleet.verdict()
    assert (verdict["ok"], verdict["exit_code"]) == (False, 1)
    assert json.loads(ended.out) == verdict
    assert fleet.leftovers() == []
