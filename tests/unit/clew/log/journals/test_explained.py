"""`clew log why` where nothing came, or a robot has no place: faults, deaths and drafts explain it."""

import shutil
from pathlib import Path

import pytest

from clew.log.journals.links import Link
from clew.log.journals.process import processes_of
from clew.log.journals.why import Why
from clew.log.timeline import read
from clew.rehearsal.recorded import Recorded
from protocol.faults.plan import NO_FAULTS
from protocol.network.session import INPUTS
from protocol.timeline import FaultInjected, RobotDied, kind_of
from tests.support.campaigns import clew
from tests.support.faults import kill
from tests.support.runs import Runs
from tests.support.scenes.corridor import PASSAGE_M, passage
from world.record.lines import Line


@pytest.fixture(scope="module")
def cut(runs: Runs) -> Path:
    """To read: for ten seconds robots 1 and 2 do not hear the others."""
    return runs.of("grove", faults="one-way")


def way(run: Path, source: str, kind: str, place: int = 0) -> list[Link]:
    """The way to one of the entries of a source and kind."""
    lines = list(read(run).lines)
    found = [at for at, (by, each) in enumerate(lines) if (by, kind_of(each.record)) == (source, kind)]
    return Why(processes_of(run), lines).way(found[place])


def dropped(lines: list[Line], key: str, to_s: float) -> list[int]:
    """The numbers of the messages on a key that a fault has dropped by then."""
    return [
        each.record.number or 0
        for _, each in lines
        if isinstance(each.record, FaultInjected) and each.record.key == key and each.t_s <= to_s
    ]


@pytest.mark.parametrize("kind", ["link.silent", "link.broken", "view.proposed"])
def test_silence_names_the_rule_and_the_messages_that_it_has_dropped(cut: Path, kind: str) -> None:
    heard, lost, decision, entry = way(cut, "r2", kind)
    lines = list(read(cut).lines)
    numbers = dropped(lines, "link/r3/r2", entry.t_s)
    assert len(numbers) > 5
    assert heard.number == numbers[0] - 1
    assert (heard.what, heard.t_s) == ("message", 2.9)
    assert (
        lost.said == f"then nothing from r3: messages {numbers[0]}-{numbers[-1]} dropped by rule partition-1"
    )
    assert (lost.source, lost.what, lost.t_s) == ("r2", "loss", 3.0)
    assert decision.said == f"notes {kind}"


def test_a_robot_that_was_frozen_is_said_to_be_where_the_world_or_a_neighbour_misses_it(runs: Runs) -> None:
    run = runs.of("grove", faults="leader-frozen")
    frozen, died = way(run, "world", "robot.died")
    assert (frozen.what, frozen.said) == ("fault", "r1 was frozen by rule freeze-1")
    assert died.said.startswith("robot.died: r1 has died")
    frozen, gone, _decision, proposed = way(run, "r2", "view.proposed")
    assert (frozen.said, gone.said) == ("r1 was frozen by rule freeze-1", "the token of r1 went")
    assert proposed.said.endswith("robot 1 is lost")


def test_a_robot_is_left_out_since_its_reports_were_lost(cut: Path) -> None:
    lost, draft, decision, heard, left, _entry = way(cut, "r4", "view.left")
    lines = list(read(cut).lines)
    numbers = dropped(lines, "view/r4/r2", draft.t_s)
    assert (
        lost.said == f"then nothing from r4: messages {numbers[0]}-{numbers[-1]} dropped by rule partition-1"
    )
    assert (draft.source, draft.what) == ("r2", "draft")
    assert draft.said.startswith("makes the strand r1 r2 of epoch 20002; left out r3: it was silent, ")
    assert "; r4: it has not reported; " in draft.said
    assert (decision.source, heard.source, left.said) == ("r2", "r4", "notes view.left")


def test_a_robot_is_left_out_since_it_was_silent_before(cut: Path) -> None:
    heard, lost, draft, *_ = way(cut, "r3", "view.left")
    assert (heard.what, lost.what, draft.what) == ("message", "loss", "draft")
    assert lost.said.startswith("then nothing from r3: messages ")


def test_a_robot_is_left_out_since_its_process_was_gone(runs: Runs) -> None:
    frozen, draft, *_ = way(runs.of("grove", faults="leader-frozen"), "r1", "view.left")
    assert frozen.said == "r1 was frozen by rule freeze-1"
    assert draft.said.endswith("left out r1: its token has gone")


@pytest.fixture(scope="module")
def plugged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """To read: robot 3 dies in a passage, and the one behind it finds no way."""
    folder = tmp_path_factory.mktemp("plugged")
    with Recorded(passage(4), 1, folder, NO_FAULTS, lambda _: None) as recorded:
        killed = False
        for _ in recorded.ticks():
            if not killed and recorded.rehearsal.world.bodies.place_m[2, 0] > PASSAGE_M / 2.0:
                kill(recorded.rehearsal, 3)
                killed = True
        recorded.judge()
    return folder


@pytest.mark.parametrize("kind", ["robot.stranded", "view.left"])
def test_a_stranded_robot_had_its_turns_in_vain(plugged: Path, kind: str) -> None:
    *turns, draft, _decision, _entry = way(plugged, "r4", kind)
    said = [link.said for link in turns]
    assert said[0] == "fence.changed: r4 has the turn: it alone may drive"
    assert any(each.startswith("robot.blocked: r4 is blocked: ") for each in said)
    assert "r3: its token has gone; r4: it has had its turn, and found no way to a place" in draft.said


def test_a_death_that_nobody_asked_for_is_told_by_when_the_robot_was_last_heard(plugged: Path) -> None:
    lines = [line for line in read(plugged).lines if not isinstance(line[1].record, FaultInjected)]
    found = next(at for at, (_, entry) in enumerate(lines) if isinstance(entry.record, RobotDied))
    dead, _ = Why(processes_of(plugged), lines).way(found)
    assert dead.said == f"r3 was dead since t={dead.t_s:.3f} s"


def test_without_the_journal_of_the_sender_the_log_still_names_what_was_lost(
    cut: Path, tmp_path: Path
) -> None:
    copy = shutil.copytree(cut, tmp_path / "run")
    for journal in (copy / INPUTS).glob("r3-*"):
        journal.unlink()
    assert [link.what for link in way(copy, "r2", "link.silent")] == ["message", "loss", "decision", "entry"]


def test_silence_that_no_fault_explains_says_what_the_sender_sent(cut: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(cut, tmp_path / "run")
    events = copy / "events.jsonl"
    kept = [line for line in events.read_bytes().splitlines(keepends=True) if b'"fault.injected"' not in line]
    events.write_bytes(b"".join(kept))
    _heard, sent, *_ = way(copy, "r2", "link.silent")
    assert sent.said.startswith("it sent messages ")
    assert sent.said.endswith(" meanwhile, and the log does not say what became of them")
    for journal in (copy / INPUTS).glob("r3-*"):
        journal.unlink()
    _heard, missing, *_ = way(copy, "r2", "link.silent")
    assert (missing.source, missing.said) == ("r3", "the journal of the sender is missing")


def test_the_state_of_a_coordinator_says_whom_its_draft_leaves_out(cut: Path) -> None:
    said = clew("replay", cut, "--until", "12", "--robot", "2")
    [draft] = [line for line in said.stdout.splitlines() if line.startswith("  view ")]
    assert " in_place=nobody " in draft
    assert " phase=gathering awaits=r4 r5 awaits_s=1.000 " in draft
    assert "r1: its turn has not come; " in draft
    assert "r4: it has not reported; r5: it has not reported" in draft
    first = clew("replay", cut, "--break", "in_place == 'r1 r2'")
    assert first.exit_code == 0
    assert " in_place=r1 r2 " in first.stdout
