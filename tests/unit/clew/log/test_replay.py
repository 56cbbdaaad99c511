"""`clew replay`: new cores repeat every decision of a run; the first one that differs is shown."""

import json
from pathlib import Path

import pytest

from agents.body.driver import Driver
from agents.process.journal import Decision, Given, open_journal
from agents.robot import Robot
from clew.log.journals.recording import Recording
from clew.log.replay import replay, sentences
from clew.rehearsal.recorded import rehearse
from protocol.errors import UsageError
from protocol.faults.plan import load as load_plan
from protocol.network.session import INPUTS
from protocol.root import ROOT
from tests.support.campaigns import clew
from tests.support.long import long
from tests.support.processes.fleets import Fleet
from tests.support.runs import Runs
from world.scenario.scenario import load

PLANS = ROOT / "launch" / "faults"


@pytest.fixture(scope="module")
def run(runs: Runs) -> Path:
    """A fleet that was rehearsed with nothing going wrong."""
    return runs.of("grove")


def turn_with_commands(run: Path, robot: int) -> int:
    """The first turn of a robot with which it did something, counted from 1."""
    (journal,) = (run / INPUTS).glob(f"r{robot}-*")
    turns = enumerate(Recording(journal).turns(), start=1)
    return next(place for place, turn in turns if turn.decision is not None and turn.decision.commands)


def rewritten(run: Path, folder: Path, *, robot: int, turn: int, decided: Decision) -> Path:
    """A copy of one robot's journal with another decision in one place."""
    (journal,) = (run / INPUTS).glob(f"r{robot}-*")
    recording = Recording(journal)
    copy = open_journal(folder / INPUTS, recording.head)
    for place, each in enumerate(recording.turns(), start=1):
        assert each.decision is not None
        copy.hear(Given(each.event, each.input.key, each.input.number), each.input.now_s)
        copy.decide(decided if place == turn else each.decision)
    copy.end(recording.ended or "")
    return folder


def test_new_cores_decide_like_the_rehearsed_ones(run: Path) -> None:
    replayed = replay(run)
    assert replayed.ok
    assert [each.robot for each in replayed.robots] == [1, 2, 3, 4, 5]
    assert all(each.decisions > 100 and each.flaws == () for each in replayed.robots)


@pytest.mark.parametrize("name", ["robot-restarted", *long(["burst", "killed-after-plan", "leader-frozen"])])
def test_cores_decide_by_their_inputs_alone_under_faults(runs: Runs, name: str) -> None:
    replayed = replay(runs.of("grove", faults=name))
    assert replayed.ok, "\n".join(sentences(replayed))
    assert replayed.decisions > 1000


LOSSY = """
name = "lossy"

[[rule]]
fault = "drop"
probability = 0.3

[[rule]]
fault = "delay"
probability = 0.5
delay_s_max = 0.2
"""


@pytest.mark.parametrize("seed", [1, *long([2])])
def test_cores_decide_by_their_inputs_alone_with_30_percent_loss(tmp_path: Path, seed: int) -> None:
    plan = tmp_path / "lossy.toml"
    plan.write_text(LOSSY, encoding="utf-8")
    folder = tmp_path / "run"
    folder.mkdir()
    rehearse(load("grove"), seed, folder, lambda _: None, load_plan(str(plan)))
    replayed = replay(folder)
    assert replayed.ok, "\n".join(sentences(replayed))


@pytest.mark.processes
def test_new_cores_decide_like_those_of_a_live_fleet(tmp_path: Path) -> None:
    fleet = Fleet(tmp_path)
    try:
        outcome = fleet.run("grove", "--speed", "max", "--out", str(tmp_path / "live"))
        assert outcome.code == 0, outcome.err
        replayed = replay(tmp_path / "live")
    finally:
        fleet.destroy()
    assert replayed.ok, "\n".join(sentences(replayed))
    assert [(each.robot, each.flaws) for each in replayed.robots] == [(robot, ()) for robot in range(1, 6)]


def test_the_first_difference_is_shown_with_both_decisions(run: Path, tmp_path: Path) -> None:
    turn = turn_with_commands(run, 2)
    changed = rewritten(run, tmp_path, robot=2, turn=turn, decided=Decision(()))
    said = clew("replay", changed)
    assert said.exit_code == 1
    lines = said.stdout.splitlines()
    assert lines[0].startswith(f"robot 2 (1): input {turn} at t=")
    assert lines[1].startswith("  event: {")
    assert any(line.startswith("  command 1, recorded: none") for line in lines)
    assert any(line.startswith("  command 1, replayed: {") for line in lines)
    told = json.loads(clew("replay", changed, "--json").stdout)
    assert not told["ok"]
    difference = told["robots"][0]["difference"]
    assert (difference["robot"], difference["input"], difference["recorded"]) == (2, turn, [])
    assert difference["replayed"] != []


def test_a_changed_core_is_found(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Driver, "stand", lambda _: None)
    slower = Driver.__init__

    def crawl(self: Driver, *, speed_mps: float, watched: bool = False) -> None:
        slower(self, speed_mps=speed_mps / 2.0, watched=watched)

    monkeypatch.setattr(Driver, "__init__", crawl)
    replayed = replay(run)
    assert not replayed.ok
    assert replayed.robots[-1].difference is not None


def test_a_core_that_raises_the_recorded_exception_decides_the_same(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = rewritten(run, tmp_path, robot=3, turn=20, decided=Decision((), "RuntimeError: planted"))
    assert clew("replay", changed).exit_code == 1
    whole = Robot.handle
    counts = dict[int, int]()

    def planted(self: Robot, event: object, now_s: float) -> object:
        counts[id(self)] = counts.get(id(self), 0) + 1
        if counts[id(self)] == 20:
            raise RuntimeError("planted")
        return whole(self, event, now_s)  # type: ignore[arg-type]  # whatever it is, as it came

    monkeypatch.setattr(Robot, "handle", planted)
    assert clew("replay", changed).exit_code == 0


def test_a_torn_journal_is_reported_and_the_rest_is_compared(run: Path, tmp_path: Path) -> None:
    (tmp_path / INPUTS).mkdir()
    for journal in (run / INPUTS).iterdir():
        content = journal.read_bytes()
        cut = len(content) // 2 if journal.name.startswith("r4-") else len(content)
        (tmp_path / INPUTS / journal.name).write_bytes(content[:cut])
    said = clew("replay", tmp_path)
    assert said.exit_code == 0
    assert "robot 4 (1): its last record is torn" in said.stdout
    assert said.stdout.splitlines()[-1].startswith("replayed: ")


def test_one_robot_can_be_replayed_alone(run: Path) -> None:
    for place in (run, run / "events.jsonl"):
        told = json.loads(clew("replay", place, "--robot", "5", "--json").stdout)
        assert [each["robot"] for each in told["robots"]] == [5]


@pytest.mark.parametrize("arguments", [(), ("--robot", "9")])
def test_nothing_to_replay_exits_2(run: Path, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    said = clew("replay", run if arguments else tmp_path, *arguments)
    assert (said.exit_code, said.stdout) == (2, "")
    if arguments:
        assert said.stderr == "Error: robot: must be a robot of the fleet, r1 to r5, got 9\n"
    with pytest.raises(UsageError, match="no inputs"):
        replay(tmp_path)
    with pytest.raises(UsageError, match=r"no run in .*nowhere: there is no such folder"):
        replay(tmp_path / "nowhere")


def test_the_same_seed_gives_the_same_journals_to_the_byte(run: Path, tmp_path: Path) -> None:
    rehearse(load("grove"), 1, tmp_path, lambda _: None)
    for journal in (run / INPUTS).iterdir():
        assert (tmp_path / INPUTS / journal.name).read_bytes() == journal.read_bytes()
