import json
import re
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from clew.cli import main
from protocol.timeline import PoseSampled, StepFinished
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import schema

STEP_3 = ("world", StepFinished(robot=1, step=3, x_m=0.1, y_m=0.2, clearance_m=0.11))


def clew(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return recorded(tmp_path / "run", numbered((STEP_3, *AT_REST)))


def test_info_says_what_was_run_and_counts_entries(run: Path) -> None:
    said = json.loads(clew("log", "info", run, "--json").stdout)
    assert (said["scenario"], said["seed"], said["entries"]) == ("paper", 1, 7)
    assert said["sources"] == {"world": 7}
    assert said["kinds"] == {"pose.sampled": 5, "run.ended": 1, "step.finished": 1}
    assert said["flaws"] == []


def test_info_for_people_names_every_kind(run: Path) -> None:
    said = clew("log", "info", run)
    assert said.exit_code == 0
    for word in ("paper", "pose.sampled", "step.finished"):
        assert word in said.stdout


def test_info_says_law_robots_and_how_the_run_ended(run: Path) -> None:
    said = json.loads(clew("log", "info", run, "--json").stdout)
    assert (said["law"], said["robots"], said["ended"]) == ("printed", 5, "interrupted")
    assert said["verdict"] is None
    for line in (r"law +printed", r"robots +5", r"ended +interrupted", r"verdict +none"):
        assert re.search(line, clew("log", "info", run).stdout), line


def test_the_time_of_a_run_is_that_of_the_verdict_and_not_of_the_last_entry(run: Path) -> None:
    said = json.loads(clew("log", "info", run, "--json").stdout)
    assert (said["sim_s"], said["last_entry_s"]) == (None, 6.0), "only the verdict knows when it was over"
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(GOOD))
    said = json.loads(clew("log", "info", run, "--json").stdout)
    assert (said["sim_s"], said["last_entry_s"]) == (GOOD.sim_s, 6.0)
    for line in (r"sim_s +31.0", r"last_entry_s +6.0"):
        assert re.search(line, clew("log", "info", run).stdout), line


@pytest.mark.parametrize("named", ["", "events.jsonl"])
def test_info_shows_the_verdict_beside_the_log(run: Path, named: str) -> None:
    failed = msgspec.structs.replace(GOOD, ok=False, exit_code=1, reason="robot 3 died")
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(failed))
    said = json.loads(clew("log", "info", run / named, "--json").stdout)
    assert said["verdict"] == {"ok": False, "exit_code": 1, "reason": "robot 3 died"}
    assert re.search(r"verdict +FAILED: robot 3 died", clew("log", "info", run / named).stdout)


def test_info_names_the_folder_of_a_run(tmp_path: Path) -> None:
    run = recorded(tmp_path / "mine", numbered(AT_REST))
    (tmp_path / "latest").symlink_to(run)
    for named in (run, run / EVENTS_FILE, tmp_path / "latest"):
        assert json.loads(clew("log", "info", named, "--json").stdout)["folder"] == str(run)
    assert re.search(r"folder +/", clew("log", "info", run).stdout)


def test_info_of_a_copied_log_takes_no_verdict_from_its_folder(run: Path) -> None:
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(GOOD))
    copy = run / "copy.jsonl"
    copy.write_bytes((run / "events.jsonl").read_bytes())
    assert json.loads(clew("log", "info", copy, "--json").stdout)["verdict"] is None


def test_info_names_a_verdict_that_cannot_be_read(run: Path) -> None:
    (run / VERDICT_FILE).write_bytes(b"{")
    said = json.loads(clew("log", "info", run, "--json").stdout)
    assert said["verdict"] is None
    assert ["verdict.json" in flaw for flaw in said["flaws"]] == [True]


def test_cat_takes_more_than_one_kind_and_source(run: Path) -> None:
    both = clew("log", "cat", run, "--kind", "step.*", "--kind", "run.ended").stdout
    assert [line.split()[2] for line in both.splitlines()] == ["step.finished", "run.ended"]
    assert clew("log", "cat", run, "--source", "r1", "--source", "world").stdout.count("\n") == 7


def test_check_says_how_the_run_ended(run: Path) -> None:
    assert json.loads(clew("log", "check", run, "--json").stdout)["ended"] == "interrupted"
    assert "ended: interrupted" in clew("log", "check", run).stdout.splitlines()


def test_cat_in_json_is_the_log_without_its_header(run: Path) -> None:
    written = (run / "events.jsonl").read_text(encoding="utf-8").splitlines()[1:]
    assert clew("log", "cat", run, "--json").stdout.splitlines() == written


def test_cat_shows_the_chosen_entries_only(run: Path) -> None:
    said = clew("log", "cat", run, "--kind", "step.*", "--step", "3").stdout
    assert said == "    0.000  world step.finished      r1 finishes step 3, 0.110 m clear\n"
    assert clew("log", "cat", run, "--robot", "1").stdout.count("\n") == 2
    assert clew("log", "cat", run, "--from", "6").stdout.count("\n") == 1


def test_cat_of_a_torn_log_warns_on_stderr_only(run: Path) -> None:
    with (run / "events.jsonl").open("ab") as file:
        file.write(b'{"t_s":1')
    said = clew("log", "cat", run, "--json")
    assert "torn" in said.stderr
    assert said.stdout.count("\n") == 7


def test_check_exits_0_on_a_good_log(run: Path) -> None:
    said = clew("log", "check", run, "--json")
    assert said.exit_code == 0, said.stdout
    assert json.loads(said.stdout)["ok"]


def test_check_exits_1_when_a_promise_was_broken(tmp_path: Path) -> None:
    jump = ("world", PoseSampled(robot=1, x_m=1.02, y_m=0.432, heading_rad=0.0))
    said = clew("log", "check", recorded(tmp_path / "run", numbered((*AT_REST[:-1], jump, AT_REST[-1]))))
    assert said.exit_code == 1
    assert "S1 (clearance), robot 1" in said.stdout


@pytest.mark.parametrize("verb", ["info", "cat", "check"])
def test_no_such_run_is_one_line_and_exit_2(tmp_path: Path, verb: str) -> None:
    said = clew("log", verb, tmp_path / "nothing")
    assert said.exit_code == 2
    assert said.stdout == ""
    assert said.stderr.count("\n") == 1
    assert "no run in" in said.stderr


def test_schema_is_that_of_the_scenario() -> None:
    assert json.loads(clew("schema").stdout) == json.loads(json.dumps(schema()))


def test_a_fault_with_no_duration_is_refused_in_one_line(tmp_path: Path) -> None:
    said = clew("fault", tmp_path, "drop", "--for", "0s")
    assert (said.exit_code, said.stderr) == (2, "Error: fault drop: $.for_s: must be > 0.0 s, got 0.0\n")
