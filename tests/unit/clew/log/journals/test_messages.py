"""`clew log messages`: each message once, with its sender, its receiver, its content and its fate."""

import json
import shutil
from collections import Counter
from pathlib import Path

import pytest
from msgspec.structs import replace

from agents.commands import Note
from agents.process.journal import Given, decision, open_journal
from clew.api.run import open_run
from clew.log.journals.fate import Fate
from clew.log.journals.messages import FATES, Chosen, Message, messages_of
from clew.log.journals.process import processes_of, sender_process
from clew.log.log import Log
from clew.rehearsal.recorded import rehearse
from protocol.faults.plan import load as load_plan
from protocol.network.session import INPUTS
from protocol.timeline import Entry, FaultInjected, MessageRefused, StepPlanned
from protocol.wire.messages import AheadState, Drive
from tests.support.campaigns import clew, scene
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import load

PLAN = """
name = "mixed"
[[rule]]
fault = "corrupt"
name = "flip"
probability = 0.1
[[rule]]
fault = "delay"
probability = 0.2
delay_s_max = 0.3
[[rule]]
fault = "drop"
probability = 0.2
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """To read: three robots in a corridor, and messages that are lost, late and damaged."""
    folder = tmp_path_factory.mktemp("mixed")
    (folder / "mixed.toml").write_text(PLAN, encoding="utf-8")
    (folder / "run").mkdir()
    scenario = load(str(scene(folder / "corridor.json")), robots=3)
    rehearse(scenario, 1, folder / "run", lambda _: None, load_plan(str(folder / "mixed.toml")))
    return folder / "run"


def told(run: Path, *options: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in clew("log", "messages", run, "--json", *options).stdout.splitlines()]


def test_every_injection_and_every_refusal_is_told_with_its_message(run: Path) -> None:
    opened = open_run(run)
    expected = dict[tuple[str, str, int, float], Fate]()
    for entry in opened.faults:
        fault = entry.record
        assert isinstance(fault, FaultInjected)
        if fault.number:  # queries and their replies have none
            place = (entry.source, str(fault.key), fault.number, entry.t_s)
            expected[place] = max(
                expected.get(place, Fate.DELIVERED), FATES[fault.fault], key=list(Fate).index
            )
    assert {*expected.values()} == {Fate.DELAYED, Fate.DROPPED, Fate.DAMAGED}
    struck = [each for each in opened.messages if each.fault and each.number]
    assert Counter(each.fate for each in struck) == Counter(expected.values())
    reasons = sorted(each.reason for each in opened.messages if each.reason)
    assert reasons == sorted(entry.reason for entry in opened.entries("message.refused"))
    assert [each for each in opened.messages if each.fate is Fate.REFUSED] == []


def test_what_a_lost_message_said_is_in_the_journal_of_its_sender(run: Path) -> None:
    lost = [each for each in open_run(run).messages if each.fate is Fate.DROPPED and each.number]
    links = [each for each in lost if each.kind == "ahead"]
    assert links
    assert all(isinstance(each.message, AheadState) for each in links)
    orders = [each for each in lost if each.receiver == "world" and each.kind == "drive"]
    assert orders
    assert all(isinstance(each.message, Drive) and each.said.startswith("order ") for each in orders)


def test_the_number_that_a_receiver_saw_is_that_of_the_message_its_sender_sent(run: Path) -> None:
    sent = {place: each.message for process in processes_of(run) for place, each in process.sent.items()}
    received = [
        each for each in open_run(run).messages if each.kind in {"ahead", "behind", "report", "answer"}
    ]
    assert len(received) > 100
    assert [each for each in received if sent[each.key, each.number] != each.message] == []


def test_messages_are_chosen_by_link_robot_step_and_fate(run: Path) -> None:
    everything = told(run)
    [begun_s] = [entry.t_s for entry in open_run(run).entries("step.planned") if not entry.joins]
    of_robot = [each for each in everything if "r2" in {each["sender"], each["receiver"]}]
    assert told(run, "--robot", "2") == of_robot
    in_steps = [each for each in of_robot if float(str(each["t_s"])) >= begun_s]
    assert 0 < len(in_steps) < len(of_robot)
    assert told(run, "--robot", "2", "--step", "1-3") == in_steps
    assert told(run, "--robot", "2", "--step", "2-3") == []
    dropped = [each for each in of_robot if each["fate"] == "dropped" and "r3" in str(each["key"])]
    assert told(run, "--link", "3,r2", "--fate", "dropped") == dropped
    assert {each["kind"] for each in told(run, "--link", "2,world", "--kind", "odometry")} == {"odometry"}
    assert all(1.0 <= float(str(each["t_s"])) <= 2.0 for each in told(run, "--from", "1", "--to", "2"))


def test_a_step_lasts_until_the_next_is_planned(run: Path) -> None:
    [plan] = [line for line in Log(run).lines if isinstance(line[1].record, StepPlanned)]
    source, entry = plan
    lines = [
        (source, replace(entry, t_s=float(step), record=replace(entry.record, step=step)))
        for step in (1, 2, 3)
    ]
    said = [
        Message(t_s, "r1", "r2", "ahead", "link/r1/r2", 1, Fate.DELIVERED)
        for t_s in (0.5, 1.5, 2.0, 2.9, 3.5)
    ]
    assert [each.t_s for each in Chosen(steps=(2, 2)).of(said, lines)] == [2.0, 2.9]
    assert [each.t_s for each in Chosen(steps=(1, 2)).of(said, lines)] == [1.5, 2.0, 2.9]


def test_a_message_that_a_core_refused_is_told_once_with_the_reason(run: Path, tmp_path: Path) -> None:
    receiver = next(each for each in processes_of(run) if each.name == "r2")
    turn = next(each for each in receiver.turns if each.input.key == "link/r3/r2")
    refused = MessageRefused(key=turn.input.key, reason="it cannot be true")
    journal = open_journal(tmp_path / INPUTS, receiver.head)
    journal.hear(Given(turn.event, turn.input.key, turn.input.number), turn.input.now_s)
    journal.decide(decision([Note(refused)]))
    journal.close()
    lines = [("r2", Entry(n=1, t_s=turn.input.now_s, hlc="", record=refused))]
    [told] = messages_of(processes_of(tmp_path), lines)
    assert (told.fate, told.kind, told.number) == (Fate.REFUSED, "behind", turn.input.number)
    assert told.said.endswith(": it cannot be true")


def test_a_sender_that_was_started_again_counts_its_messages_anew(runs: Runs) -> None:
    run = runs.of("grove", faults="robot-restarted")
    processes = processes_of(run)
    received = [
        each for each in messages_of(processes, Log(run).lines) if each.kind in {"ahead", "behind", "report"}
    ]
    by_process = Counter[str]()
    for each in received:
        place = (each.key, each.number)
        process = sender_process(processes, place, each.t_s, receiver=each.receiver, message=each.message)
        assert process is not None
        assert process.sent[place].message == each.message
        by_process[process.path.stem] += 1
    assert {"r3-1", "r3-2"} < {*by_process}


def test_a_line_says_when_who_what_and_how_it_ended(run: Path) -> None:
    [line, *_] = clew(
        "log", "messages", run, "--link", "1,2", "--kind", "ahead", "--fate", "dropped"
    ).stdout.splitlines()
    time_s, sender, arrow, receiver, kind, _number, fate, *said = line.split()
    assert (sender, arrow, receiver, kind, fate) == ("r1", "->", "r2", "ahead", "dropped")
    assert float(time_s) > 0.0
    assert "drop-3) at " in " ".join(said)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--link", "2"), "must be two robots"),
        (("--link", "2,x"), "must be two robots"),
        (("--link", "2,r2"), "must be two robots"),
        (("--step", "4-2"), "must be like 2 or 2-4"),
        (("--fate", "droped"), "did you mean 'dropped'"),
        (("--kind", "aheads"), "there is no kind 'aheads'; did you mean 'ahead'"),
        (("--robot", "9"), "robot: must be a robot of the fleet, r1 to r"),
        (("--link", "2,9"), "robot: must be a robot of the fleet, r1 to r"),
        (
            ("--link", "2,world", "--from", "5", "--to", "2"),
            "time: must be from an earlier time to a later one",
        ),
    ],
)
def test_a_choice_that_makes_no_sense_is_refused(run: Path, options: tuple[str, ...], reason: str) -> None:
    said = clew("log", "messages", run, *options)
    assert (said.exit_code, said.stdout) == (2, "")
    assert reason in said.stderr


def test_without_inputs_it_says_what_is_missing_and_shows_what_the_log_has(run: Path, tmp_path: Path) -> None:
    shutil.copy(run / EVENTS_FILE, tmp_path)
    said = clew("log", "messages", tmp_path)
    assert said.exit_code == 0
    assert f"{tmp_path / INPUTS} has no journals of robots" in said.stderr
    assert "dropped" in said.stdout
    assert "delivered" not in said.stdout
    (tmp_path / INPUTS).mkdir()
    for journal in (run / INPUTS).glob("r[12]-*"):
        shutil.copy(journal, tmp_path / INPUTS)
    said = clew("log", "messages", tmp_path)
    assert "not complete: robot 3 (1): has no journal, though by the log it took part" in said.stderr
    assert {each["receiver"] for each in told(tmp_path, "--fate", "delivered")} == {"r1", "r2"}


def test_entries_are_chosen_by_rule_and_by_key(run: Path) -> None:
    said = clew("log", "cat", run, "--rule", "fl*", "--key", "link/r2/*", "--json").stdout.splitlines()
    entries = [json.loads(line) for line in said]
    assert {(each["kind"], each["rule"]) for each in entries} == {("fault.injected", "flip")}
    assert {each["key"] for each in entries} == {"link/r2/r1", "link/r2/r3"}
    assert [each.as_dict()["n"] for each in open_run(run).entries(rule="fl*", key="link/r2/*")] == [
        each["n"] for each in entries
    ]
    assert "message.refused" in clew("log", "cat", run, "--key", "link/*").stdout
