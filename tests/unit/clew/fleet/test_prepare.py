import re
import shlex
import subprocess
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from clew.fleet.folder import folder_name
from clew.fleet.prepare import assignment, main, run_name, shows
from clew.fleet.request import parse
from protocol.errors import UsageError
from protocol.faults.plan import load as load_plan
from protocol.network.session import read_session
from protocol.run_settings import Settings, read_plan, read_settings
from world.record.run_files import read_scenario
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import load

NOON = datetime(2026, 11, 20, 12, 0, 0, tzinfo=UTC)
ANY_TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=20)


@pytest.fixture
def private(tmp_path: Path) -> Path:
    folder = tmp_path / "private"
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def somewhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder of its own, so that nothing of a test lands in the project's `runs/`."""
    folder = tmp_path / "cwd"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def test_nothing_asked_means_the_paper_at_real_time_with_seed_1() -> None:
    request = parse([])
    assert (request.scenario, request.robots, request.seed, request.speed) == ("paper", None, 1, 1.0)


def test_what_is_asked_is_written_into_the_runs_folder_resolved(private: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_bytes((SCENARIOS / "grove.toml").read_bytes())
    asked = [
        str(own),
        "-n",
        "3",
        "--seed",
        "7",
        "--law",
        "resultant",
        "--speed",
        "max",
        "--faults",
        "loss-50",
    ]
    run = tmp_path / "run"
    assert main([str(private), *asked, "--out", str(run)]) == 0
    own.unlink()
    assert read_scenario(run) == load("grove", robots=3, law="resultant", seed=7)
    assert read_settings(run) == Settings(seed=7, speed=None)
    assert read_plan(run) == load_plan("loss-50")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["-n", "0"], "argument -n: must be a whole number from 1 to 2000, got 0"),
        (["-n", "many"], "got many"),
        (["--seed", "-1"], "argument --seed: "),
        (["--speed", "0"], r"must be max or a number in \(0, 1000\], got 0"),
        (["--speed", "nan"], "got nan"),
        (["--law", "murphy"], "argument --law: invalid choice: 'murphy'"),
        (["-e", "tcp/a:1", "-l", "tcp/b:1"], "not allowed with argument"),
        (["--routers", "2", "-l", "tcp/b:1"], "argument --routers: .*not allowed with"),
        (["--routers", "3"], "argument --routers: invalid choice"),
        (["--sped", "2"], "unrecognized arguments: --sped"),
        (["paper", "grove"], "unrecognized arguments: grove"),
    ],
)
def test_option_that_cannot_be_is_refused_by_name(arguments: list[str], complaint: str) -> None:
    with pytest.raises(UsageError, match=complaint):
        parse(arguments)


def test_help_goes_to_stdout_and_names_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--help"])
    said = capsys.readouterr()
    assert stop.value.code == 0
    assert said.err == ""
    for option in (
        "SCENARIO",
        "-n",
        "--seed",
        "--law",
        "--speed",
        "--out",
        "--json",
        "--view",
        "--quiet",
        "--connect",
        "--listen",
    ):
        assert option in said.out


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["atlantis"], "atlantis"),
        (["-n", "0"], "-n"),
        (["--out", "/proc/clew/run"], "cannot write a run into /proc/clew/run"),
        (["--out", "new/" + "x" * 300], "File name too long"),  # by then `new` has been made
        (
            ["--faults", "one-way", "-n", "3"],
            "$.rule[0].group[1]: must be a robot of the fleet, r1 to r3, got r4",
        ),
        (["--listen", "nonsense"], "nonsense"),
        (["--listen", "unixsock-stream//tmp/" + "x" * 120], "107 bytes"),
    ],
)
def test_refusal_is_one_line_and_leaves_nothing(
    arguments: list[str],
    complaint: str,
    private: Path,
    somewhere_else: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([str(private), *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("fleet.sh: ")
    assert said.err.count("\n") == 1
    assert complaint in said.err
    assert list(somewhere_else.iterdir()) == []


def test_folder_that_is_not_empty_is_refused(
    private: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(private), "--out", str(tmp_path)]) == 2
    assert "is not empty" in capsys.readouterr().err


def test_good_request_makes_the_folder_and_says_all_that_bash_needs(
    private: Path, somewhere_else: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(private), "paper", "--out", "it's/here", "--json"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    value = dict(line.split("=", 1) for line in said.out.splitlines())
    assert value["robots"] == "5"
    assert value["own_routers"] == "1"
    assert value["as_json"] == "1"
    assert value["view"] == "0"
    assert value["shows"] == "lines"
    assert value["latest"] == "''"
    assert shlex.split(value["run_folder"]) == ["it's/here"]
    assert (somewhere_else / "it's" / "here").is_dir()
    made = shlex.split(value["made_folders"].strip("()"))
    assert made == [str(somewhere_else / "it's" / "here"), str(somewhere_else / "it's")]
    assert (private / "r5.json").exists()
    assert (private / "world.json").exists()


def test_our_own_router_asks_for_passwords(private: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(private)]) == 0
    assert read_session(private / "r1.json").password
    assert "own_routers=1\n" in capsys.readouterr().out


def test_run_without_out_gets_a_folder_of_its_own_in_runs(
    private: Path, somewhere_else: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(private)]) == 0
    (folder,) = (somewhere_else / "runs").iterdir()
    assert re.fullmatch(r"\d{8}T\d{6}Z-paper-[0-9a-f]{4}", folder.name)
    assert "latest=runs/latest\n" in capsys.readouterr().out


def test_names_sort_by_time_and_fit_into_a_key() -> None:
    assert run_name(NOON, "0a1b") == "20261120T120000Z-0a1b"
    assert folder_name(NOON, "scenes/barn 003.json", "0a1b") == "20261120T120000Z-barn-003-0a1b"
    assert folder_name(NOON, "/", "0a1b") == "20261120T120000Z-scenario-0a1b"


@settings(max_examples=20)  # each example starts a bash
@given(text=ANY_TEXT, items=st.lists(ANY_TEXT, max_size=4))
def test_bash_gets_exactly_what_was_said(text: str, items: list[str]) -> None:
    script = "\n".join([assignment("a", text), assignment("b", items), 'printf \'%s\\0\' x "$a" "${b[@]}"'])
    said = subprocess.run(["bash", "-c", script], capture_output=True, check=True).stdout
    assert said.decode().split("\0")[:-1] == ["x", text, *items]


@pytest.mark.parametrize(
    ("arguments", "environment", "terminal", "shown"),
    [
        ([], {"TERM": "xterm"}, True, "table"),
        ([], {"TERM": "xterm"}, False, "lines"),
        ([], {"TERM": "dumb"}, True, "lines"),
        ([], {}, True, "lines"),
        ([], {"TERM": "xterm", "CI": "true"}, True, "lines"),
        (["--json"], {"TERM": "xterm"}, True, "lines"),
        (["--quiet"], {"TERM": "xterm"}, True, "nothing"),
        (["--quiet"], {}, False, "nothing"),
    ],
)
def test_table_is_for_people_at_a_terminal_and_lines_for_all_else(
    arguments: list[str], environment: dict[str, str], terminal: bool, shown: str
) -> None:
    assert shows(parse(arguments), environment, terminal=terminal) == shown
