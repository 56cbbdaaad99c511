"""Whole fleets: real processes over real Zenoh, as a user starts them."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.support.processes.fleets import END_S_MAX, RUN_S_MAX, START_S_MAX, Fleet, Outcome, clew, wait_until


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Fleet, Outcome]]:
    fleet = Fleet(tmp_path_factory.mktemp("paper"))
    yield fleet, fleet.run("paper", "--seed", "1", "--speed", "max", "--json")
    fleet.destroy()


@contextmanager
def stock_router(endpoint: str) -> Iterator[None]:
    """A router of Zenoh that knows nothing of us."""
    script = (
        "import sys, zenoh; c = zenoh.Config(); c.insert_json5('mode', '\"router\"');"
        f"c.insert_json5('listen/endpoints', '[\"{endpoint}\"]');"
        "c.insert_json5('scouting/multicast/enabled', 'false');"
        "s = zenoh.open(c); print('ready', flush=True); sys.stdin.read(); s.close()"
    )
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as router:
        assert router.stdout is not None
        assert router.stdin is not None
        assert router.stdout.readline() == "ready\n"
        yield
        router.stdin.close()
        assert router.wait(END_S_MAX) == 0


def rewritten(fleet: Fleet, kind: str, change: dict[str, object] | None) -> Path:
    """A copy of the log whose last entry of a kind is changed, or removed."""
    copy = fleet.cwd / "copy.jsonl"
    lines = (fleet.folder() / "events.jsonl").read_text(encoding="utf-8").splitlines()
    last = max(index for index, line in enumerate(lines) if json.loads(line)["kind"] == kind)
    changed = [] if change is None else [json.dumps(json.loads(lines[last]) | change)]
    copy.write_text("\n".join([*lines[:last], *changed, *lines[last + 1 :], ""]), encoding="utf-8")
    return copy


def test_paper_crosses_its_scene_and_gives_table_i_back(paper: tuple[Fleet, Outcome]) -> None:
    fleet, outcome = paper
    assert outcome.code == 0, outcome.err
    assert outcome.out == (fleet.folder() / "verdict.json").read_text(encoding="utf-8")
    verdict = fleet.verdict()
    assert verdict["ok"]
    assert (verdict["robots"], verdict["robots_arrived"], verdict["law"]) == (5, 5, "printed")
    assert verdict["events"]["missing"] == 0
    assert verdict["messages"]["unaccounted"] == 0
    assert verdict["table_rms_m"] <= 0.035


def test_fleet_leaves_its_run_and_nothing_else(paper: tuple[Fleet, Outcome]) -> None:
    fleet, _ = paper
    assert fleet.leftovers() == []
    assert sorted(path.name for path in fleet.folder().iterdir()) == [
        "events.jsonl",
        "inputs",
        "verdict.json",
    ]
    assert (fleet.cwd / "runs" / "latest").is_symlink()


def test_log_of_a_good_run_is_judged_good_again(paper: tuple[Fleet, Outcome]) -> None:
    fleet, _ = paper
    checked = clew("log", "check", "runs/latest", "--json", cwd=fleet.cwd)
    assert checked.returncode == 0, checked.stdout
    finding = json.loads(checked.stdout)
    verdict = fleet.verdict()
    assert finding["clearance_m_min"] == pytest.approx(verdict["clearance_m_min"], abs=1e-6)
    assert finding["separation_m_min"] == pytest.approx(verdict["separation_m_min"], abs=1e-6)
    assert finding["violations"] == verdict["violations"]


@pytest.mark.parametrize(
    ("kind", "change", "complaint"),
    [
        ("pose.sampled", {"x_m": 1.02, "y_m": 0.432}, "S1"),  # the middle of obstacle 2
        ("authority.granted", {"authority_m": 0.0}, "S3"),
        ("authority.granted", None, "entries are missing"),
    ],
)
def test_log_that_was_tampered_with_is_found_out(
    paper: tuple[Fleet, Outcome], kind: str, change: dict[str, object] | None, complaint: str
) -> None:
    fleet, _ = paper
    checked = clew("log", "check", str(rewritten(fleet, kind, change)), cwd=fleet.cwd)
    assert checked.returncode == 1
    assert complaint in checked.stdout


def test_report_prints_the_table_and_ends_with_verdict_and_folder(paper: tuple[Fleet, Outcome]) -> None:
    fleet, _ = paper
    command = [sys.executable, "-m", "clew.fleet.summary", "runs/latest"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    said = subprocess.run(
        command,
        cwd=fleet.cwd,
        env=environment,
        capture_output=True,
        text=True,
        timeout=START_S_MAX,
        check=True,
    ).stdout.splitlines()
    assert any("Table I" in line and "RMS" in line for line in said)
    assert "runs/latest" in said[-1]


def test_grove_is_crossed_with_the_clearance_that_was_promised(fleet: Fleet) -> None:
    outcome = fleet.run("grove", "--seed", "1", "--speed", "max", "--json")
    assert outcome.code == 0, outcome.err
    verdict = json.loads(outcome.out)
    assert verdict["ok"]
    assert verdict["law"] == "certified"
    assert verdict["clearance_m_min"] >= verdict["clearance_m_required"] > 0.0


def test_two_fleets_at_once_do_not_disturb_each_other(fleet: Fleet, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = Fleet(tmp_path / "other")
    try:
        for each in (fleet, other):
            each.start("paper", "--speed", "max", "--json")
        outcomes = [each.end(RUN_S_MAX) for each in (fleet, other)]
        assert [outcome.code for outcome in outcomes] == [0, 0], outcomes
        assert fleet.leftovers() + other.leftovers() == []
    finally:
        other.destroy()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["atlantis"], "atlantis"),
        (["paper", "-n", "0"], "-n"),
        (["paper", "--out", "/proc/clew"], "/proc/clew"),
        (["paper", "--speed", "fast"], "--speed"),
    ],
)
def test_request_that_cannot_be_is_one_line_and_exit_2(
    fleet: Fleet, arguments: list[str], complaint: str
) -> None:
    outcome = fleet.run(*arguments, timeout_s=START_S_MAX)
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1, outcome.err
    assert complaint in outcome.err
    assert fleet.leftovers() == []
    assert list(fleet.cwd.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("range_m_max =", "range_m_maxx =", "range_m_maxx"),
        ("at_m = [", "at_m = [-999.0, -999.0] # [", "goal"),
        ("spacing_m =", "spacing_m = 0.0001 #", "spacing_m"),
        ("robots = 5", "robots = 0", "robots"),
        ("robots = 5", "robots = = 5", "line"),
    ],
)
def test_scenario_that_cannot_be_is_one_line_and_exit_2(
    fleet: Fleet, old: str, new: str, complaint: str
) -> None:
    text = (ROOT / "launch" / "scenarios" / "grove.toml").read_text(encoding="utf-8")
    assert old in text
    (fleet.cwd / "mine.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    outcome = fleet.run("mine.toml", timeout_s=START_S_MAX)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1, outcome.err
    assert "mine.toml" in outcome.err
    assert complaint in outcome.err
    assert fleet.leftovers() == []
    assert [path.name for path in fleet.cwd.iterdir()] == ["mine.toml"]


def test_port_that_is_taken_is_one_line_and_exit_2(fleet: Fleet) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        outcome = fleet.run("paper", "--listen", endpoint, timeout_s=START_S_MAX)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1, outcome.err
    assert endpoint in outcome.err
    assert fleet.leftovers() == []
    assert list(fleet.cwd.iterdir()) == []


def test_router_that_is_not_there_is_one_line_and_exit_2(fleet: Fleet) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    outcome = fleet.run("paper", "--connect", endpoint, timeout_s=START_S_MAX)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1, outcome.err
    assert endpoint in outcome.err
    assert fleet.leftovers() == []
    assert list(fleet.cwd.iterdir()) == []


def test_router_that_the_user_runs_serves_as_well(fleet: Fleet) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    with stock_router(endpoint):
        outcome = fleet.run("paper", "--speed", "max", "--json", "--connect", endpoint)
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["messages"]["unaccounted"] == 0


@pytest.mark.parametrize(("asked", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_fleet_that_is_asked_to_stop_writes_its_verdict_and_goes(
    fleet: Fleet, asked: signal.Signals, code: int
) -> None:
    launcher = fleet.start("paper", "--json")
    fleet.wait_for("order.accepted")
    launcher.send_signal(asked)
    outcome = fleet.end(END_S_MAX)
    assert outcome.code == code
    assert not json.loads(outcome.out)["ok"]
    assert "run.ended" in {entry["kind"] for entry in fleet.entries()}
    assert fleet.leftovers() == []


def test_host_that_is_killed_ends_the_run_and_is_named(fleet: Fleet) -> None:
    fleet.start("paper")
    fleet.wait_for("order.accepted")
    os.kill(fleet.process("agents"), signal.SIGKILL)
    outcome = fleet.end(END_S_MAX)
    assert outcome.code == 1, outcome.err
    assert "host was killed by SIGKILL" in outcome.err
    assert fleet.entries()
    assert fleet.leftovers() == []


def test_world_that_is_frozen_is_killed_in_time(fleet: Fleet) -> None:
    launcher = fleet.start("paper")
    fleet.wait_for("order.accepted")
    os.kill(fleet.process("world"), signal.SIGSTOP)
    launcher.send_signal(signal.SIGTERM)
    outcome = fleet.end(END_S_MAX)
    assert outcome.code == 143
    assert fleet.leftovers() == []


def test_nothing_outlives_a_launcher_that_is_killed(fleet: Fleet) -> None:
    launcher = fleet.start("paper")
    fleet.wait_for("order.accepted")
    launcher.kill()
    wait_until(lambda: None if fleet.leftovers() else True, END_S_MAX)
