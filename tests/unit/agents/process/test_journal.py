"""Journals: inputs and decisions are on disk before they have any effect."""

import gzip
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.commands import AskScan
from agents.process.journal import Given, Head, Journal, decision, open_journal
from clew.log.journals.recording import Recording, Turn
from protocol.errors import UsageError
from protocol.process.tokens import TokenCame
from tests.support.strategies.examples import examples
from world.scenario.scenario import load

HEAD = Head(robot=3, incarnation="0a1b", mission=load("paper").mission(), life=9)
HEARD = Given(TokenCame(2, "1"), "alive/r2/1", 0)
DECIDED = decision([AskScan(1)])


def written(folder: Path, turns: int) -> Path:
    """A complete journal with this number of turns."""
    journal = open_journal(folder, HEAD)
    for turn in range(turns):
        journal.hear(HEARD, turn / 10.0)
        journal.decide(DECIDED)
    journal.end("the run is over")
    return folder / "r3-0a1b.clew"


def read(path: Path) -> tuple[Recording, list[Turn]]:
    recording = Recording(path)
    return recording, list(recording.turns())


def test_a_journal_is_read_back_with_the_reason_for_its_end(tmp_path: Path) -> None:
    recording, turns = read(written(tmp_path / "inputs", 3))
    assert (recording.head, recording.ended, recording.flaw) == (HEAD, "the run is over", None)
    assert [(turn.input.now_s, turn.input.key) for turn in turns] == [
        (0.0, "alive/r2/1"),
        (0.1, "alive/r2/1"),
        (0.2, "alive/r2/1"),
    ]
    assert all(turn.event == HEARD.event for turn in turns)
    assert all(turn.decision is not None for turn in turns)


@settings(deadline=None, max_examples=examples(40))
@given(st.data())
def test_everything_before_a_tear_is_read(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("torn")
    path = written(folder / "inputs", 3)
    whole = path.read_bytes()
    begin = open_journal(folder / "head", HEAD)
    begin.close()
    begin_bytes = (folder / "head" / path.name).stat().st_size
    kept = data.draw(st.integers(begin_bytes, len(whole)))
    path.write_bytes(whole[:kept])
    recording, turns = read(path)
    assert len(turns) <= 3
    assert [turn.input.now_s for turn in turns] == [0.0, 0.1, 0.2][: len(turns)]
    assert not recording.damaged
    assert (recording.ended, recording.flaw) == ("the run is over", None) or kept < len(whole)
    assert all(turn.decision is not None for turn in turns[:-1])


def test_a_torn_record_is_reported_with_its_length(tmp_path: Path) -> None:
    path = written(tmp_path / "inputs", 1)
    path.write_bytes(path.read_bytes()[:-3])
    recording, turns = read(path)
    assert len(turns) == 1
    assert recording.flaw is not None
    assert "torn" in recording.flaw


@settings(deadline=None, max_examples=examples(100))
@given(st.binary(max_size=300))
def test_no_bytes_after_the_head_make_the_reader_raise(
    tmp_path_factory: pytest.TempPathFactory, rest: bytes
) -> None:
    path = written(tmp_path_factory.mktemp("spoilt") / "inputs", 1)
    path.write_bytes(path.read_bytes() + rest)
    recording, _ = read(path)
    assert rest == b"" or recording.flaw is not None


@pytest.mark.parametrize("content", [b"", b"\x00", b"\xc1", b"{}", b"\xdd\xff\xff\xff\xff"])
def test_a_file_that_does_not_begin_as_a_journal_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "r3-0a1b.clew"
    path.write_bytes(content)
    with pytest.raises(UsageError, match="does not begin as a journal"):
        Recording(path)


def test_a_full_journal_says_so_and_records_no_more(tmp_path: Path) -> None:
    path = tmp_path / "r3-0a1b.clew"
    with path.open("xb", buffering=0) as file:
        journal = Journal(file, size_bytes_max=2000)
        journal.begin(HEAD)
        for _ in range(1000):
            journal.hear(HEARD, 0.0)
            journal.decide(DECIDED)
    recording, turns = read(path)
    assert (recording.ended, recording.flaw) == ("full", None)
    assert 0 < len(turns) < 1000
    assert path.stat().st_size <= 2000 + 100, "the record that filled it, and its end"


def test_a_journal_that_is_not_packed_is_read_as_before(tmp_path: Path) -> None:
    path = written(tmp_path, 3)
    packed_bytes = path.stat().st_size
    path.write_bytes(gzip.decompress(path.read_bytes()))
    recording, turns = read(path)
    assert (len(turns), recording.ended, recording.flaw) == (3, "the run is over", None)
    assert path.stat().st_size > packed_bytes
    path.write_bytes(path.read_bytes()[:-3])
    recording, turns = read(path)
    assert (len(turns), recording.ended, recording.damaged) == (3, None, False)
    assert "torn" in (recording.flaw or "")


@settings(deadline=None, max_examples=examples(40))
@given(st.data())
def test_a_changed_byte_makes_no_wrong_turn_without_a_word(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = written(tmp_path_factory.mktemp("changed"), 3)
    _, before = read(path)
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(10, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(content)
    try:
        recording, turns = read(path)
    except UsageError:
        return
    assert recording.damaged or (recording.head, turns) == (HEAD, before)


def test_what_repeats_costs_some_bytes(tmp_path: Path) -> None:
    some, more = (written(tmp_path / f"{turns}", turns).stat().st_size for turns in (10, 110))
    assert (more - some) / 100 < 40, "a turn of 60 bytes, of which only the time differs"


def test_without_the_folder_of_the_run_no_journal_is_kept(tmp_path: Path) -> None:
    journal = open_journal(tmp_path / "elsewhere" / "inputs", HEAD)
    journal.hear(HEARD, 0.0)
    journal.end("the run is over")
    assert list(tmp_path.iterdir()) == []


def test_a_journal_is_never_overwritten(tmp_path: Path) -> None:
    path = written(tmp_path / "inputs", 2)
    before = path.read_bytes()
    written(tmp_path / "inputs", 1)
    assert path.read_bytes() == before


def test_an_input_is_on_disk_as_soon_as_the_decision_on_it_is(tmp_path: Path) -> None:
    journal = open_journal(tmp_path, HEAD)
    for turn in (1, 2):
        journal.hear(HEARD, 0.5 * turn)
        journal.decide(DECIDED)
        _, turns = read(tmp_path / "r3-0a1b.clew")
        assert [each.input.now_s for each in turns] == [0.5, 1.0][:turn]
        assert None not in [each.decision for each in turns]
    journal.hear(HEARD, 1.5)
    journal.end("the run is over")
    _, turns = read(tmp_path / "r3-0a1b.clew")
    assert [each.decision is None for each in turns] == [False, False, True]
    journal.close()


def test_what_a_journal_keeps_is_on_disk_when_it_is_closed(tmp_path: Path) -> None:
    names = ("kept", "at once")
    kept, at_once = (open_journal(tmp_path / names[i], HEAD, keeps_bytes=2000 * (1 - i)) for i in (0, 1))
    paths = [tmp_path / name / "r3-0a1b.clew" for name in names]
    for turn in range(60):
        for journal in (kept, at_once):
            journal.hear(HEARD, turn / 10.0)
            journal.decide(DECIDED)
    _, turns = read(paths[0])
    assert 0 < len(turns) < 60, "more than it keeps has been written, and the rest has not"
    kept.close()
    at_once.close()
    assert len(read(paths[0])[1]) == 60
    assert read(paths[0])[1] == read(paths[1])[1]
    assert paths[0].stat().st_size < paths[1].stat().st_size, "it is packed in few pieces"
