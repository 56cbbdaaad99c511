"""Whole fleets of real processes over real Zenoh, started as a user starts them."""

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from clew.fleet.summary import summary_of
from tests.support.campaigns import clew as clew_here
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import LAUNCHER, Fleet, Outcome, clew


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Fleet, Outcome]]:
    fleet = Fleet(tmp_path_factory.mktemp("paper"))
    yield fleet, fleet.run("paper", "--seed", "1", "--speed", "max", "--json")
    fleet.destroy()


@contextmanager
def stock_router(endpoint: str) -> Iterator[None]:
    """A stock Zenoh router without our rules."""
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
        assert router.wait(DEADLINE_S) == 0


def rewritten(fleet: Fleet, kind: str, change: dict[str, object] | None) -> Path:
    """A copy of the log whose last entry of a kind is changed, or removed."""
    copy = fleet.cwd / "copy.jsonl"
    lines = (fleet.folder() / "events.jsonl").read_text(encoding="utf-8").splitlines()
    last = max(index for index, line in enumerate(lines) if json.loads(line)["kind"] == kind)
    changed = [] if change is None else [json.dumps(json.loads(lines[last]) | change)]
    copy.write_text("\n".join([*lines[:last], *changed, *lines[last + 1 :], ""]), encoding="utf-8")
    return copy


def test_paper_crosses_its_scene_and_reproduces_table_i(paper: tuple[Fleet, Outcome]) -> None:
    fleet, outcome = paper
    assert outcome.code == 0, outcome.err
    assert "r1 plans step 1" in outcome.err
    assert "\x1b" not in outcome.err
    assert outcome.out == (fleet.folder() / "verdict.json").read_text(encoding="utf-8")
    verdict = fleet.verdict()
    assert verdict["ok"]
    assert (verdict["robots"], verdict["robots_arrived"], verdict["law"]) == (5, 5, "printed")
    assert verdict["events"]["missing"] == 0
    assert verdict["messages"]["unaccounted"] == 0
    assert verdict["table_rms_m"] <= 0.035


def test_fleet_leaves_only_its_run_folder(paper: tuple[Fleet, Outcome]) -> None:
    fleet, _ = paper
    assert fleet.leftovers() == []
    assert sorted(path.name for path in fleet.folder().iterdir()) == [
        "events.jsonl",
        "inputs",
        "run.toml",
        "scenario.toml",
        "verdict.json",
    ]
    assert (fleet.cwd / "runs" / "latest").is_symlink()


def test_log_check_passes_on_a_good_run(paper: tuple[Fleet, Outcome]) -> None:
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
        ("pose.sampled", {"x_m": 1.02, "y_m": 0.432}, "S1 (clearance)"),  # the middle of obstacle 2
        ("authority.granted", {"authority_m": 0.0}, "F5 (authority)"),
        ("authority.granted", None, "entries are missing"),
    ],
)
def test_log_check_detects_a_tampered_log(
    paper: tuple[Fleet, Outcome], kind: str, change: dict[str, object] | None, complaint: str
) -> None:
    fleet, _ = paper
    checked = clew_here("log", "check", rewritten(fleet, kind, change))
    assert checked.exit_code == 1
    assert complaint in checked.stdout


def test_report_prints_the_table_and_ends_with_verdict_and_folder(paper: tuple[Fleet, Outcome]) -> None:
    fleet, _ = paper
    said = summary_of(str(fleet.folder())).splitlines()
    assert any("Table I" in line and "RMS" in line for line in said)
    assert said[-1].endswith(f"Run: {fleet.folder()}")


def test_grove_is_crossed_with_the_promised_clearance(fleet: Fleet) -> None:
    outcome = fleet.run("grove", "--seed", "1", "--speed", "max", "--json")
    assert outcome.code == 0, outcome.err
    verdict = json.loads(outcome.out)
    assert verdict["ok"]
    assert verdict["law"] == "certified"
    assert verdict["clearance_m_min"] >= verdict["clearance_m_required"] > 0.0


@pytest.mark.long  # in the short form, too, most fleets run at once: those of other tests
def test_two_fleets_at_once_do_not_disturb_each_other(fleet: Fleet, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = Fleet(tmp_path / "other")
    try:
        for each in (fleet, other):
            each.start("paper", "-n", "2", "--speed", "max", "--json")
        outcomes = [each.end() for each in (fleet, other)]
        assert [outcome.code for outcome in outcomes] == [0, 0], outcomes
        assert fleet.leftovers() + other.leftovers() == []
    finally:
        other.destroy()


def test_impossible_request_is_refused_in_one_line_with_exit_2(fleet: Fleet) -> None:
    outcome = fleet.run("atlantis")
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.count("\n") == 1, outcome.err
    assert "atlantis" in outcome.err
    assert fleet.leftovers() == []
    assert list(fleet.cwd.iterdir()) == []


def test_parts_start_when_the_caller_has_closed_stdin_stdout_and_stderr(fleet: Fleet) -> None:
    command = 'exec "$0" "$@" <&- >&- 2>&-'
    fleet.start_with("bash", "-c", command, str(LAUNCHER), "paper", "-n", "2", "--speed", "max")
    assert fleet.end() == Outcome(0, "", "")
    assert fleet.verdict()["ok"]
    assert fleet.leftovers() == []


def test_missing_router_is_reported_in_one_line_with_exit_2(fleet: Fleet) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    outcome = fleet.run("paper", "--connect", endpoint)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1, outcome.err
    assert endpoint in outcome.err
    assert fleet.leftovers() == []
    assert list(fleet.cwd.iterdir()) == []


def test_fleet_runs_over_the_users_own_router(fleet: Fleet) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    with stock_router(endpoint):
        outcome = fleet.run("paper", "-n", "2", "--speed", "max", "--json", "--connect", endpoint)
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["messages"]["unaccounted"] == 0


@pytest.mark.parametrize("part", ["protocol", "world"])
def test_router_and_world_allocate_from_one_arena(fleet: Fleet, part: str) -> None:
    """Other arenas of glibc are pieces of 64 MiB, most of which is only reserved."""
    fleet.start("paper", "-n", "2", "--speed", "0.5")
    fleet.wait_for("strand.formed")
    maps = Path(f"/proc/{fleet.process(part)}/maps").read_text(encoding="utf-8").splitlines()
    reserved = [line.split("-")[1].split()[0] for line in maps if line.split()[1] == "---p"]
    assert [end for end in reserved if int(end, 16) % (64 << 20) == 0] == []
