"""`clew replay --until` and `--break`: a core's state at a moment, and the first event that made it so."""

import json
import re
import shutil
from pathlib import Path

import msgspec
import pytest

from agents.body.driver import Driver
from agents.process.journal import Given, open_journal
from clew.log.journals.condition import LENGTH_MAX, Condition
from clew.log.journals.recording import Recording
from clew.log.journals.state import NAMES
from clew.log.timeline import read
from protocol.errors import UsageError
from protocol.network.session import INPUTS
from protocol.root import ROOT
from protocol.timeline import LeaderSucceeded, PoseSampled, StrandJoined
from tests.support.campaigns import clew
from tests.support.runs import Runs


@pytest.fixture(scope="module")
def run(runs: Runs) -> Path:
    """To read: the leader dies, and the next robot leads."""
    return runs.of("grove", faults="leader-killed")


def test_it_stops_at_the_event_that_made_the_next_robot_the_leader(run: Path) -> None:
    said = clew("replay", run, "--break", "generation > 1 and leads", "--json")
    [told] = [json.loads(line) for line in said.stdout.splitlines()]
    [(source, entry, record)] = [
        (source, entry, entry.record)
        for source, entry in read(run).lines
        if isinstance(entry.record, LeaderSucceeded)
    ]
    assert (f"r{told['robot']}", told["t_s"], told["epoch"]) == (source, entry.t_s, record.epoch)
    assert {"kind": "Note", "record": msgspec.to_builtins(record)} in told["decided"]
    assert (said.exit_code, told["differs"], said.stderr) == (0, None, "")


def test_of_all_robots_it_stops_at_the_first(run: Path) -> None:
    [told] = clew("replay", run, "--break", "state == 'member'", "--json").stdout.splitlines()
    joined = [line for line in read(run).lines if isinstance(line[1].record, StrandJoined)]
    source, entry = min(joined, key=lambda line: (line[1].t_s, line[0]))
    stopped = json.loads(told)
    assert (f"r{stopped['robot']}", stopped["t_s"]) == (source, entry.t_s)


def test_the_state_at_a_time_is_that_of_the_log(run: Path) -> None:
    told = [json.loads(line) for line in clew("replay", run, "--until", "8", "--json").stdout.splitlines()]
    assert [each["robot"] for each in told] == [1, 2, 3, 4, 5]
    assert told[0]["t_s"] < 8.0, "the killed robot is shown as it was"
    lines = [line for line in read(run).lines if line[1].t_s <= 8.0]
    joined = {source: entry.record for source, entry in lines if isinstance(entry.record, StrandJoined)}
    poses = {entry.record.robot: entry.record for _, entry in lines if isinstance(entry.record, PoseSampled)}
    for each in told[1:]:
        place = joined[f"r{each['robot']}"]
        assert (each["epoch"], each["rank"], each["members"]) == (place.epoch, place.rank, place.members)
        assert each["x_m"] == pytest.approx(poses[each["robot"]].x_m, abs=0.1)  # one odometry, and its error
    assert [each["ahead"] for each in told[1:]] == [None, 2, 3, 4]


def test_for_people_it_names_what_expressions_may_ask(run: Path) -> None:
    lines = clew("replay", run, "--until", "8", "--robot", "3").stdout.splitlines()
    assert lines[0].startswith("r3 (1) at t=8.000 s, after input ")
    names = [word.partition("=")[0] for line in lines[1:6] for word in line.split()[1:]]
    assert {"state", "leads", "ahead", "x_m"} < set(names) <= set(NAMES)
    begun = clew("replay", run, "--until", "8", "--robot", "3", "--break", "state == 'member'").stdout
    assert "  then    it notes strand.joined: r3 takes place 3 in the strand" in begun.splitlines()


def test_an_expression_that_never_becomes_true_exits_1(run: Path) -> None:
    said = clew("replay", run, "--break", "generation > 9")
    assert (said.exit_code, said.stdout) == (1, "")
    assert "after no event is this true: generation > 9" in said.stderr
    assert clew("replay", run, "--break", "generation > 1", "--until", "2").exit_code == 1


def test_a_changed_core_is_said_to_differ(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Driver, "stand", lambda _: None)
    monkeypatch.setattr(Driver, "to", lambda *_, **__: None)
    said = clew("replay", run, "--until", "8", "--robot", "3")
    assert said.exit_code == 1
    assert "it decides otherwise than recorded" in said.stderr


def test_missing_inputs_are_named(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    for journal in (tmp_path / "run" / INPUTS).glob("r[2-4]-*"):
        journal.unlink()
    said = clew("replay", tmp_path / "run", "--until", "8")
    assert "not complete: robot 3 (1): has no journal, though by the log it took part" in said.stderr
    said = clew("replay", tmp_path / "run", "--until", "8", "--robot", "3")
    assert (said.exit_code, said.stdout) == (2, "")
    assert "no inputs of robot 3 to replay" in said.stderr


VALUES = {"epoch": 20_002, "leads": True, "state": "member", "x_m": 1.5, "ahead": None}


@pytest.mark.parametrize(
    ("text", "is_true"),
    [
        ("epoch > 3", True),
        ("epoch > 3 and not leads", False),
        ("state == 'member' or epoch < 0", True),
        ("1 < x_m <= 1.5 < 2", True),
        ("state in ('bound', 'aside')", False),
        ("state not in ['bound', 'aside']", True),
        ("x_m * 2 - 1 == 2 and -x_m < +0", True),
        ("ahead == None", True),
        ("ahead < 3 or ahead >= 3 or ahead + 1 > 0", False),  # what is not there is neither
        ("x_m / 0 > 1", False),
        ("ahead", False),
    ],
)
def test_an_expression_is_read_as_it_stands(text: str, *, is_true: bool) -> None:
    assert Condition(text, tuple(VALUES)).holds(VALUES) is is_true


@pytest.mark.parametrize(
    "text",
    [
        "",
        "epoch >",
        "epoch = 3",
        "epok > 3",
        "__import__('os').system('true')",
        "leads.__class__",
        "epoch ** 9",
        "1 / 0",
        "True",
        "[x for x in (1, 2)]",
        "x_m if leads else 1",
        "epoch if",
        "(lambda: 1)()",
        "state[0]",
        "f'{state}'",
        "epoch is 3",
        "epoch in epoch",
        "epoch == (1, 2)",
        "b'a' == state",
        "1j == x_m",
        "... == x_m",
        "(" * 190,
        "-" * LENGTH_MAX + "1",
        "state > 3",
        "state + 'a' == 'b'",
        "state * 9 == state",
    ],
)
def test_any_other_expression_is_refused_before_anything_runs(text: str) -> None:
    with pytest.raises(UsageError):
        Condition(text, tuple(VALUES)).holds(VALUES)


@pytest.fixture(scope="module")
def cut(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same, in which robot 2 kept the beginning of its inputs."""
    folder = tmp_path_factory.mktemp("cut") / "run"
    shutil.copytree(run, folder)
    [path] = (folder / INPUTS).glob("r2-*")
    recording = Recording(path)
    turns = list(recording.turns())
    path.unlink()
    journal = open_journal(folder / INPUTS, recording.head, size_bytes_max=path_bytes(run, 2) // 2)
    for turn in turns:
        assert turn.decision is not None
        journal.hear(Given(turn.event, turn.input.key, turn.input.number), turn.input.now_s)
        journal.decide(turn.decision)
    assert not journal.keeps
    return folder


def path_bytes(run: Path, robot: int) -> int:
    [path] = (run / INPUTS).glob(f"r{robot}-*")
    return path.stat().st_size


def test_what_was_kept_of_the_inputs_replays_exactly(cut: Path) -> None:
    said = clew("replay", cut)
    assert said.exit_code == 0
    assert re.search(
        r"robot 2 \(\w+\): inputs of r2 after t=\d+\.\d s were not kept: its journal was full", said.stdout
    )
    said = clew("replay", cut, "--until", "2", "--robot", "2", "--json")
    assert (said.exit_code, json.loads(said.stdout)["differs"]) == (0, None)


@pytest.mark.parametrize(
    "options",
    [("--until", "18"), ("--until", "18", "--robot", "2"), ("--break", "t_s > 18"), ("--break", "t_s > 1e9")],
)
def test_a_moment_whose_inputs_were_not_kept_is_refused(cut: Path, options: tuple[str, ...]) -> None:
    said = clew("replay", cut, *options)
    assert (said.exit_code, said.stdout) == (2, "")
    assert "inputs of r2 after t=" in said.stderr
    assert "were not kept: its journal was full" in said.stderr


def test_an_event_before_the_kept_inputs_end_is_found(cut: Path) -> None:
    assert clew("replay", cut, "--break", "state == 'member'").exit_code == 0


def test_messages_say_which_inputs_were_not_kept(cut: Path) -> None:
    assert "inputs of r2 after t=" in clew("log", "messages", cut, "--robot", "2").stderr


def test_a_wrong_expression_exits_2_and_names_the_names(run: Path) -> None:
    said = clew("replay", run, "--break", "epok > 3")
    assert (said.exit_code, said.stdout) == (2, "")
    assert "there is no name 'epok'; did you mean 'epoch'?; the names are t_s, robot, " in said.stderr


def test_the_page_explains_every_name() -> None:
    page = (ROOT / "docs" / "replay.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if f"`{name}`" not in page] == []
