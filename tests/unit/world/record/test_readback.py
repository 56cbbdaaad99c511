"""The record against the file: what stands there is read back, and what does not is counted."""

import contextlib
from collections.abc import Iterator
from io import FileIO
from pathlib import Path

import pytest

from protocol.timeline import Entry, LinkHeard, Record, RobotStarted
from tests.support.logs.logs import HEADER
from world.record.readback import READ_BYTES, Readback
from world.record.recorder import EVENTS_FILE, Recorder, RecordingFailedError, Written, line, open_events

HEARD = LinkHeard(neighbour=2)


@pytest.fixture
def file(tmp_path: Path) -> Iterator[FileIO]:
    with open_events(tmp_path / "run") as opened:
        yield opened


@pytest.fixture
def written() -> Written:
    return Written()


@pytest.fixture
def recorder(file: FileIO, written: Written) -> Recorder:
    return Recorder(file, HEADER, written)


@pytest.fixture
def readback(tmp_path: Path, file: FileIO) -> Iterator[Readback]:
    with contextlib.closing(Readback(tmp_path / "run", file)) as opened:
        yield opened


def entry(n: int, record: Record = HEARD) -> Entry:
    return Entry(n=n, t_s=n / 10, hlc="", record=record)


def read_all(readback: Readback) -> list[tuple[str, int]]:
    found = [(source, each.n) for source, each in readback.read()]
    while readback.is_behind:
        found += [(source, each.n) for source, each in readback.read()]
    return found


def test_entries_are_read_once_as_they_are_written(recorder: Recorder, readback: Readback) -> None:
    assert read_all(readback) == []
    recorder.take("r1", [entry(1), entry(2)])
    assert read_all(readback) == [("r1", 1), ("r1", 2)]
    recorder.take("world", [entry(1)])
    recorder.take("r1", [entry(3)])
    assert read_all(readback) == [("world", 1), ("r1", 3)]
    assert (readback.read_count, readback.lost(recorder.written)) == (4, 0)


def test_a_long_file_is_read_in_parts(recorder: Recorder, readback: Readback) -> None:
    many = 3 * READ_BYTES // len(line("r1", entry(1)))
    recorder.take("r1", [entry(n) for n in range(1, many + 1)])
    assert 0 < len(readback.read()) < many / 2
    assert readback.is_behind
    read_all(readback)
    assert (readback.read_count, readback.lost(recorder.written)) == (many, 0)


def test_an_entry_that_was_counted_and_not_written_is_lost(
    recorder: Recorder, written: Written, readback: Readback
) -> None:
    recorder.take("r1", [entry(1)])
    written.recall("r1", "", entry(2))  # as a recorder does that leaves the write out
    assert (read_all(readback), readback.lost(recorder.written)) == ([("r1", 1)], 1)
    recorder.take("r1", [entry(3)])
    assert (read_all(readback), readback.lost(recorder.written)) == ([("r1", 3)], 1)


@pytest.mark.parametrize("damage", [b'"n":#', b'"n":' + b"[" * 9999], ids=["wrong", "deep"])
def test_a_damaged_line_is_lost(
    recorder: Recorder, readback: Readback, tmp_path: Path, damage: bytes
) -> None:
    recorder.take("r1", [entry(1), entry(2), entry(3)])
    path = tmp_path / "run" / EVENTS_FILE
    path.write_bytes(path.read_bytes().replace(b'"n":2', damage))
    assert read_all(readback) == [("r1", 1), ("r1", 3)]
    assert readback.lost(recorder.written) == 1


def test_a_gap_in_the_numbers_is_lost(
    recorder: Recorder, written: Written, readback: Readback, file: FileIO
) -> None:
    """A resumed world counts what it finds, so only the numbers show it."""
    for n in (1, 2, 5):
        file.write(line("r1", entry(n)))
        written.recall("r1", "", entry(n))
    assert len(read_all(readback)) == 3
    assert readback.lost(recorder.written) == 2


def test_a_source_that_goes_back_is_no_copy(readback: Readback, file: FileIO) -> None:
    Recorder(file, HEADER)
    for n in (1, 2, 3, 2):
        file.write(line("r1", entry(n)))
    read_all(readback)
    assert readback.lost({"r1": 4}) == 1


def test_a_new_process_counts_from_one(recorder: Recorder, readback: Readback) -> None:
    recorder.take("r1", [entry(1), entry(2)], "a")
    recorder.take("r1", [entry(1, RobotStarted(pid=7, incarnation="b")), entry(2)], "b")
    assert len(read_all(readback)) == 4
    assert readback.lost(recorder.written) == 0


def test_a_removed_or_replaced_file_is_noticed(
    recorder: Recorder, readback: Readback, tmp_path: Path
) -> None:
    recorder.take("r1", [entry(1)])
    readback.check()
    path = tmp_path / "run" / EVENTS_FILE
    text = path.read_bytes()
    path.unlink()
    with pytest.raises(RecordingFailedError, match="was removed: the run has no record any more"):
        readback.check()
    path.write_bytes(text)
    with pytest.raises(RecordingFailedError, match="was replaced"):
        readback.check()


def test_a_file_that_was_cut_off_is_noticed(recorder: Recorder, readback: Readback, tmp_path: Path) -> None:
    recorder.take("r1", [entry(1)])
    with (tmp_path / "run" / EVENTS_FILE).open("r+b") as other:
        other.truncate(10)
    with pytest.raises(RecordingFailedError, match="was cut off"):
        readback.check()
