"""`clew replay` is ok for complete journals only; damaged or missing ones are reported and fail."""

import gzip
import json
from pathlib import Path

import msgspec
import pytest

from agents.process.journal import SUFFIX
from clew.log.journals.recording import Recording
from clew.log.replay_missing import NEVER_STARTED, NO_MISSION
from protocol.network.session import INPUTS
from protocol.wire.codec import packed
from tests.support.campaigns import clew
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE

DAMAGE_AT = 5000  # of tens of thousands of bytes
MISSING_1 = {"robot": 1, "incarnation": "1", "excuse": None, "is_empty": False}


@pytest.fixture
def run(runs: Runs, tmp_path: Path) -> Path:
    """A copy, to be spoilt. Its journals are not packed, like older ones: so their records can be found."""
    copy = runs.copy(tmp_path / "run", "grove")
    for journal in (copy / INPUTS).iterdir():
        journal.write_bytes(gzip.decompress(journal.read_bytes()))
    return copy


def journal_of(run: Path, robot: int) -> Path:
    (journal,) = (run / INPUTS).glob(f"r{robot}-*")
    return journal


def overwrite(path: Path, at: int, content: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(at)
        file.write(content)


def begin_of_second_half(path: Path) -> int:
    """Where a decision begins, half way through a journal."""
    content = path.read_bytes()
    return content.index(b"\x93\xa3out", len(content) // 2)


def test_an_unreadable_record_fails_and_the_rest_is_reported_as_not_compared(run: Path) -> None:
    overwrite(journal_of(run, 1), DAMAGE_AT, b"\xc1" * 6)
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "robot 1 (1): the record at byte " in said.stdout
    assert "the journal is damaged or of another version, and the rest was not compared" in said.stdout
    assert "all the same" not in said.stdout
    told = json.loads(clew("replay", run, "--json").stdout)
    assert not told["ok"]
    assert [each["damaged"] for each in told["robots"]] == [True, False, False, False, False]


def test_a_changed_length_is_not_taken_for_a_torn_end(run: Path) -> None:
    journal = journal_of(run, 3)
    overwrite(journal, begin_of_second_half(journal), b"\xdc\x0f\xff")  # an array of so many items
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "it has no end" in said.stdout
    assert "is torn" not in said.stdout


def test_a_removed_record_is_noticed(run: Path) -> None:
    journal = journal_of(run, 2)
    content, begin = journal.read_bytes(), begin_of_second_half(journal)
    journal.write_bytes(content[:begin] + content[content.index(b"\x96\xa2in", begin) :])
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "robot 2 (1): a record stands where it cannot" in said.stdout


@pytest.mark.parametrize("more", [b"\x96\xa2in", packed(["end", "again"])])
def test_a_record_after_the_end_is_a_failure(run: Path, more: bytes) -> None:
    with journal_of(run, 5).open("ab") as file:
        file.write(more)
    assert clew("replay", run).exit_code == 1


def test_damage_before_the_first_decision_is_not_taken_for_missing_inputs(run: Path) -> None:
    journal = journal_of(run, 1)
    overwrite(journal, journal.read_bytes().index(b"\x96\xa2in"), b"\xc1")
    assert clew("replay", run, "--robot", "1").exit_code == 1


def test_a_journal_torn_in_its_last_record_is_accepted(run: Path) -> None:
    journal = journal_of(run, 1)
    content, begin = journal.read_bytes(), begin_of_second_half(journal)
    length = content.index(b"\x96\xa2in", begin) - begin
    journal.write_bytes(content[: begin + length // 2])
    said = clew("replay", run)
    assert said.exit_code == 0
    assert "robot 1 (1): its last record is torn" in said.stdout


def test_a_robot_without_a_journal_is_named_and_is_a_failure(run: Path) -> None:
    journal_of(run, 1).unlink()
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "robot 1 (1): has no journal, though by the log it took part" in said.stdout
    assert "all the same" not in said.stdout
    told = json.loads(clew("replay", run, "--json").stdout)
    assert (told["ok"], told["missing"]) == (False, [MISSING_1])
    assert clew("replay", run, "--robot", "2").exit_code == 0, "nobody asked for robot 1"


@pytest.mark.parametrize("is_packed", [True, False])
@pytest.mark.parametrize("size_bytes", [0, 1, 20])
def test_a_journal_without_a_whole_record_is_named_and_the_others_are_replayed(
    run: Path, size_bytes: int, *, is_packed: bool
) -> None:
    whole = journal_of(run, 1).read_bytes()
    journal_of(run, 1).write_bytes((gzip.compress(whole) if is_packed else whole)[:size_bytes])
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "robot 1 (1): has only an empty journal, though by the log it took part" in said.stdout
    assert [f"robot {robot} (1): the same" in said.stdout for robot in range(1, 6)] == [False, *[True] * 4]
    told = json.loads(clew("replay", run, "--json").stdout)["missing"]
    assert told == [MISSING_1 | {"is_empty": True}]
    for verb in (("replay", run, "--until", 8), ("log", "messages", run)):
        said = clew(*verb)
        assert (said.exit_code, "not complete: robot 1 (1): has only an empty journal" in said.stderr) == (
            0,
            True,
        )


def test_a_robot_that_was_started_again_has_two_journals(runs: Runs, tmp_path: Path) -> None:
    run = runs.copy(tmp_path / "run", "grove", faults="robot-restarted")
    first, _ = sorted(
        path for path in (run / INPUTS).iterdir() if len(lives(run, Recording(path).head.robot)) > 1
    )
    assert clew("replay", run, "--robot", str(Recording(first).head.robot)).exit_code == 0
    first.unlink()
    said = clew("replay", run)
    assert said.exit_code == 1
    assert "(1): has no journal, though" in said.stdout


def lives(run: Path, robot: int) -> list[Path]:
    return list((run / INPUTS).glob(f"r{robot}-*"))


@pytest.mark.parametrize(("began", "excuse"), [(True, NO_MISSION), (False, NEVER_STARTED)])
def test_a_robot_without_a_mission_may_have_no_journal(run: Path, *, began: bool, excuse: str) -> None:
    journal_of(run, 4).unlink()
    log = run / EVENTS_FILE
    kept = ["robot.started"] if began else []
    lines = [
        line
        for line in log.read_bytes().splitlines(keepends=True)
        if (said := msgspec.json.decode(line))["source"] != "r4" or said["kind"] in kept
    ]
    log.write_bytes(b"".join(lines))
    said = clew("replay", run)
    assert said.exit_code == 0
    assert "robot 4" in said.stdout
    assert f"has no journal, as it may: {excuse}" in said.stdout
    if began:
        (run / INPUTS / f"r4-1{SUFFIX}").touch()  # it was killed before it wrote the first record
        said = clew("replay", run)
        assert (said.exit_code, f"has only an empty journal, as it may: {excuse}" in said.stdout) == (
            0,
            True,
        )


def test_without_a_log_it_is_unknown_whether_a_journal_is_missing(run: Path) -> None:
    (run / EVENTS_FILE).unlink()
    said = clew("replay", run)
    assert said.exit_code == 0
    assert "without a readable events.jsonl it is unknown whether a journal is missing" in said.stdout
