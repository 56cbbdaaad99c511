"""`clew log why`: the way from a scan, a token or the start, over decisions and messages, to an entry."""

import json
import shutil
from collections import Counter
from itertools import islice, pairwise, takewhile
from pathlib import Path

import pytest

from agents.body.driver import Driver
from agents.commands import Note
from agents.events import OdometryHeard, ScanHeard
from agents.robot import Robot
from clew.log.journals.entries import find_entry, noted
from clew.log.journals.links import Link
from clew.log.journals.process import Process, processes_of
from clew.log.journals.trials import NOTHING, Trials
from clew.log.journals.why import Why
from clew.log.timeline import read
from clew.verbs.log_why import line_of
from protocol.errors import UsageError
from protocol.network.session import INPUTS
from protocol.timeline import AuthorityGranted, LinkSilent, OrderAccepted, Record, StepPlanned, kind_of
from protocol.wire.messages import AheadState
from tests.support.campaigns import clew
from tests.support.runs import Runs
from world.record.lines import Line

BY_SHELLS = {"robot.started", "robot.settled", "traffic.counted", "fault.injected"}


@pytest.fixture(scope="module")
def run(runs: Runs) -> Path:
    """To read: the leader dies, and the next robot leads."""
    return runs.of("grove", faults="leader-killed")


@pytest.fixture(scope="module")
def lines(run: Path) -> list[Line]:
    return list(read(run).lines)


@pytest.fixture(scope="module")
def why(processes: list[Process], lines: list[Line]) -> Why:
    return Why(processes, lines)


@pytest.fixture(scope="module")
def processes(run: Path) -> list[Process]:
    return processes_of(run)


@pytest.fixture(scope="module")
def lossy(runs: Runs) -> tuple[list[Process], list[Line]]:
    """To read: half of all messages are lost, so that robots tell again what they have told."""
    run = runs.of("grove", faults="loss-50")
    return processes_of(run), list(read(run).lines)


def first(lines: list[Line], source: str, kind: str) -> int:
    return next(at for at, (by, entry) in enumerate(lines) if (by, kind_of(entry.record)) == (source, kind))


def process(processes: list[Process], name: str) -> Process:
    return next(each for each in processes if each.name == name)


def told(way: list[Link]) -> list[tuple[str, str]]:
    return [(link.source, link.what) for link in way]


def test_the_next_robot_leads_because_the_token_of_the_first_went(why: Why, lines: list[Line]) -> None:
    way = why.way(first(lines, "r2", "leader.succeeded"))
    assert way[0].said.startswith("r1 was killed by rule ")
    assert way[1].said == "the token of r1 went"
    assert way[2].said == "puts raise: propose view 20002, a neighbour is lost"
    assert ("r2", "token", "from then on it watched the tokens of all") in [
        (link.source, link.what, link.said) for link in way
    ]
    assert told(way)[1:4] == [("r2", "token"), ("r2", "decision"), ("world", "entry")]
    assert told(way)[-4:] == [("world", "entry"), ("r2", "odometry"), ("r2", "decision"), ("r2", "entry")]
    assert way[-3].said.endswith("fence 20002/1 all [fence]")
    answers = [link for link in way if link.what == "message"]
    assert answers
    assert all(link.number > 0 and link.key.startswith("view/") for link in answers)


def test_a_robot_drives_because_the_robot_ahead_granted_it_the_way(why: Why, lines: list[Line]) -> None:
    orders = (
        at
        for at, (_, entry) in enumerate(lines)
        if isinstance(entry.record, OrderAccepted) and entry.record.robot == 3 and entry.t_s > 5.0
    )
    way = why.way(next(orders))
    assert told(way)[-1] == ("world", "entry")
    assert way[-2].said.startswith("orders its body, order ")
    granted = next(link for link in reversed(way) if link.what == "message")
    assert granted.source == "r3"
    assert granted.said.startswith("r2 told ahead: ")
    assert "authority_m" in granted.said.partition("[")[2]
    assert way[0].what == "scan"


def test_a_step_was_planned_from_a_scan_and_without_that_it_was_not(
    processes: list[Process], why: Why, lines: list[Line]
) -> None:
    index = first(lines, "r2", "step.planned")
    way = why.way(index)
    assert told(way) == [("r2", "scan"), ("r2", "law"), ("r2", "decision"), ("r2", "entry")]
    planner = process(processes, "r2")

    def notes(without: int) -> list[Record]:
        core = Robot(2, planner.head.mission, life=planner.head.life)
        commands = []
        for place, turn in enumerate(planner.turns[: way[1].input], start=1):
            event = NOTHING if place == without else turn.event
            commands = core.handle(event, turn.input.now_s)
        return [command.record for command in commands if isinstance(command, Note)]

    assert isinstance(planner.turns[way[0].input - 1].event, ScanHeard)
    assert lines[index][1].record in notes(without=0)
    assert not any(isinstance(each, StepPlanned) for each in notes(without=way[0].input))


def test_the_way_to_a_step_names_what_its_law_chose_it_among(why: Why, lines: list[Line]) -> None:
    index = first(lines, "r1", "step.planned")
    plan = lines[index][1].record
    assert isinstance(plan, StepPlanned)
    said = next(link.said for link in why.way(index) if link.what == "law")
    assert said.startswith("certified: the goal is ")
    assert f"; the step goes {plan.length_m:.3f} m at {plan.heading_rad:.3f} rad, where " in said
    assert f"leaves a cost-to-go of {plan.cost_to_go_m:.3f} m, of " in said
    order = next(
        at
        for at, (_, entry) in enumerate(lines)
        if isinstance(entry.record, OrderAccepted) and entry.record.step
    )
    assert [link.said for link in why.way(order) if link.what == "law"] == [said]


def test_every_note_of_a_core_is_found_in_the_decision_that_made_it(
    processes: list[Process], lines: list[Line]
) -> None:
    found = 0
    for index, (source, entry) in enumerate(lines):
        if source == "world" or kind_of(entry.record) in BY_SHELLS:
            continue
        place = noted(processes, lines, index)
        assert place is not None, entry
        assert Note(entry.record) in list(place.process.commands(place.turn))
        found += 1
    assert found > 100


def test_notes_are_found_among_the_entries_of_shells(lossy: tuple[list[Process], list[Line]]) -> None:
    processes, lines = lossy
    notes = [at for at, (_, entry) in enumerate(lines) if isinstance(entry.record, AuthorityGranted)]
    assert len(notes) > 20
    for index in notes[::20]:
        place = noted(processes, lines, index)
        assert place is not None
        assert Note(lines[index][1].record) in list(place.process.commands(place.turn))


def test_silence_leads_to_the_last_message_that_was_heard_and_to_those_that_were_lost(
    lossy: tuple[list[Process], list[Line]],
) -> None:
    processes, lines = lossy
    silences = [at for at, (_, each) in enumerate(lines) if isinstance(each.record, LinkSilent)]
    index, entry = silences[-1], lines[silences[-1]][1]
    record = entry.record
    assert isinstance(record, LinkSilent)
    heard, lost, _decision, _entry = Why(processes, lines).way(index)
    assert (heard.what, heard.key) == ("message", f"link/r{record.neighbour}/{lines[index][0]}")
    assert heard.t_s == pytest.approx(entry.t_s - record.silent_s, abs=0.15)
    assert lost.said.startswith(f"then nothing from r{record.neighbour}: message")
    assert lost.said.endswith(" dropped by rule drop-1")


def test_a_message_leads_to_where_its_sender_first_told_what_mattered(
    lossy: tuple[list[Process], list[Line]],
) -> None:
    processes, lines = lossy
    why, repeated = Why(processes, lines), 0
    orders = (
        at
        for at, (_, each) in enumerate(lines)
        if isinstance(each.record, OrderAccepted) and each.record.robot == 3 and each.t_s > 5.0
    )
    for index in islice(orders, 4):
        for told_by, heard in pairwise(why.way(index)):
            if heard.what != "message" or not heard.said.endswith("[authority_m]"):
                continue
            sent = process(processes, told_by.source).sent
            numbers = range(heard.number, 0, -1)
            told = (sent[heard.key, number].message for number in numbers)
            grants = [each.authority_m for each in told if isinstance(each, AheadState)]
            same = list(takewhile(grants[0].__eq__, grants))
            assert told_by.input == sent[heard.key, heard.number - len(same) + 1].turn + 1
            repeated += len(same) > 1
    assert repeated > 0, "a grant was told again, since the first message was lost"


def test_an_entry_is_given_by_its_number_or_as_a_printed_line(run: Path, why: Why, lines: list[Line]) -> None:
    index = first(lines, "r2", "leader.succeeded")
    entry = lines[index][1]
    line = clew("log", "cat", run, "--kind", "leader.succeeded").stdout.rstrip()
    assert find_entry(lines, f"r2:{entry.n}") == find_entry(lines, line) == index
    poses = clew("log", "cat", run, "--kind", "pose.sampled", "--from", "1", "--to", "1").stdout.splitlines()
    assert find_entry(lines, "leader.succeeded") == index
    with pytest.raises(
        UsageError, match=rf"^{len(poses)} entries given; choose one: world:\d+ at .* s, world:\d+"
    ):
        find_entry(lines, "\n".join(poses))
    assert len({find_entry(lines, pose) for pose in poses}) == len(poses) > 1
    assert line_of(why.way(index)[-1]) == (
        f"{entry.t_s:9.3f}     r2 entry     leader.succeeded: r2 leads instead of r1"
    )


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        ("r2", "an entry is r3:17"),
        ("", "0 entries given; choose one"),
        ("step.planned", "choose one: r1:6 at 0.1 s, r2:"),
        ("r2:99999", "the log has no entry r2:99999; `clew log info` counts those that it has"),
        ("    3.301     r2 view.proposed", "the log has no entry 3.301     r2 view.proposed; "),
        ("    0.600  world pose.sampled", "choose one by its number"),
    ],
)
def test_an_entry_that_is_not_there_or_not_one_is_refused(run: Path, entry: str, reason: str) -> None:
    said = clew("log", "why", run, entry)
    assert (said.exit_code, said.stdout) == (2, "")
    assert reason in said.stderr


def test_of_a_robot_that_was_started_again_the_process_is_chosen(runs: Runs) -> None:
    run = runs.of("grove", faults="robot-restarted")
    starts = Counter(source for source, entry in read(run).lines if kind_of(entry.record) == "robot.started")
    [(robot, _)] = starts.most_common(1)
    said = clew("log", "why", run, f"{robot}:2")
    assert said.exit_code == 2
    assert f"choose one as {robot}:2:1" in said.stderr
    ways = [clew("log", "why", run, f"{robot}:2:{life}").stdout for life in (1, 2)]
    assert all(way.splitlines()[-1].split()[2] == "entry" for way in ways)
    assert ways[0] != ways[1]


def test_missing_journals_are_said(run: Path, tmp_path: Path, lines: list[Line]) -> None:
    copy = shutil.copytree(run, tmp_path / "run")
    succeeded = f"r2:{lines[first(lines, 'r2', 'leader.succeeded')][1].n}"
    for journal in (copy / INPUTS).glob("r[345]-*"):
        journal.unlink()
    said = clew("log", "why", copy, succeeded)
    assert said.exit_code == 0
    assert "not complete: robot 5 (1): has no journal" in said.stderr
    assert "the journal of the sender is missing" in said.stdout.splitlines()[0]
    shutil.rmtree(copy / INPUTS)
    said = clew("log", "why", copy, succeeded)
    assert (said.exit_code, said.stdout) == (2, "")
    assert "has no journals of robots" in said.stderr


def test_entries_of_shells_and_of_the_world_end_the_way(why: Why, lines: list[Line]) -> None:
    assert told(why.way(first(lines, "r3", "robot.started"))) == [("r3", "end"), ("r3", "entry")]
    assert why.way(first(lines, "world", "robot.appeared"))[0].said == "the world itself recorded it"
    served = why.way(first(lines, "world", "scan.served"))
    assert "asks for a scan of" in served[-2].said


def test_a_core_that_decides_otherwise_says_nothing_of_causes(
    run: Path, lines: list[Line], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Driver, "to", lambda *_, **__: None)
    said = clew("log", "why", run, f"r2:{lines[first(lines, 'r2', 'step.planned')][1].n}")
    assert (said.exit_code, said.stdout) == (2, "")
    assert "it decides otherwise than recorded" in said.stderr


def test_the_effects_of_a_step_spread_from_robot_to_robot(
    run: Path, processes: list[Process], why: Why, lines: list[Line]
) -> None:
    index = first(lines, "r2", "step.planned")
    effects = why.effects(index)
    assert {link.source for link in effects} == {"world", "r3", "r4", "r5"}
    order = next(link for link in effects if link.source == "world")
    assert order.said.startswith("order.accepted: the body of r2 accepts order ")
    on = next(link for link in effects if link.source == "r3")
    assert on.said.startswith("tells r4, ahead: ")
    follower = process(processes, "r3")
    assert (on.key, follower.turns[on.input - 1].input.number) == ("link/r2/r3", on.number)
    shown = clew("log", "why", run, f"r2:{lines[index][1].n}", "--effects", "--json").stdout.splitlines()
    assert [json.loads(each) for each in shown] == [each.as_dict() for each in (*why.way(index), *effects)]


def test_silenced_odometry_still_tells_the_time(processes: list[Process]) -> None:
    leader = process(processes, "r1")
    seen = [turn for turn, each in enumerate(leader.turns) if isinstance(each.event, OdometryHeard)]
    cause = Trials(leader).cause(seen[-1], lambda command: type(command).__name__ == "Order")
    assert cause is not None
    assert cause.turn < seen[5], "an order is repeated whatever the odometry says"
