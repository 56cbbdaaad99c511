"""Damaged logs: each flaw is reported once, and the rest is read."""

import os
from itertools import product
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from clew.log import log as lab_log
from clew.log import timeline
from clew.log.completeness import TOLD_MAX, Numbers
from clew.log.header import UNKNOWN
from clew.log.log import Log
from protocol.errors import UsageError
from protocol.timeline import RobotHeld, RobotReleased, RunEnded
from tests.support.campaigns import clew
from tests.support.logs.logs import HEADER, numbered, recorded
from world.record.lines import Line
from world.record.recorder import EVENTS_FILE, line

LINES = numbered(
    (
        ("r1", RobotHeld(behind_m=1.0)),
        ("r1", RobotReleased()),
        ("r1", RobotHeld(behind_m=2.0)),
        ("world", RunEnded(reason="interrupted")),
    )
)
TEXTS = [line(source, entry) for source, entry in LINES]


@pytest.fixture(scope="module")
def header(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return (recorded(tmp_path_factory.mktemp("header") / "run", []) / "events.jsonl").read_bytes()


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("run") / "events.jsonl"


def through(path: Path, content: bytes) -> tuple[list[Line], tuple[str, ...]]:
    """What a log of this content holds, and its flaws."""
    path.write_bytes(content)
    log = Log(path)
    return list(log.lines), log.flaws


@given(keep=st.floats(0.0, 1.0))
def test_a_log_cut_anywhere_reads_as_the_lines_before_the_cut(path: Path, header: bytes, keep: float) -> None:
    whole = b"".join(TEXTS)
    cut = whole[: round(keep * len(whole))]
    lines, flaws = through(path, header + cut)
    assert lines == LINES[: cut.count(b"\n")]
    assert any("is torn" in flaw for flaw in flaws) == (not cut.endswith(b"\n") and cut != b"")
    assert any("no run.ended" in flaw for flaw in flaws) == (len(lines) < len(LINES))


@given(st.lists(st.binary(max_size=40).map(lambda text: text.replace(b"\n", b"")), max_size=5))
def test_no_garbage_raises_and_each_line_of_it_is_reported(
    path: Path, header: bytes, garbage: list[bytes]
) -> None:
    lines, flaws = through(path, header + b"".join(text + b"\n" for text in garbage) + b"".join(TEXTS))
    assert lines == LINES
    assert len(flaws) == len(garbage)


@pytest.mark.parametrize(
    "damage",
    [
        b'{"t_s":1.0,"hlc":"0/0","source":"r\xff1","n":2,"kind":"robot.released"}',  # no UTF-8
        b"[" * 100_000,  # brackets in brackets: a parser's stack
        b'{"t_s":NaN,"hlc":"0/0","source":"r1","n":2,"kind":"robot.released"}',
        b'{"t_s":1e999,"hlc":"0/0","source":"r1","n":2,"kind":"robot.released"}',
        b"\0" * 4096,  # what a file system leaves after a power cut
        b"",
        b"null",
    ],
)
def test_a_damaged_line_is_reported_and_its_number_is_missing(
    path: Path, header: bytes, damage: bytes
) -> None:
    texts = [TEXTS[0], damage + b"\n", *TEXTS[2:]]
    lines, (first, second) = through(path, header + b"".join(texts))
    assert lines == [LINES[0], *LINES[2:]]
    assert first.startswith("line 3 cannot be read: ")
    assert second == "r1: 1 of 3 entries are missing, the first is number 2"


@pytest.mark.parametrize("block_bytes", [1, 150, 400, 1 << 18])
@pytest.mark.parametrize(
    ("between", "end"),
    list(
        product(
            [b"\n", b" \n\n", TEXTS[0].replace(b",", b",\n", 1), TEXTS[0][:-1] + TEXTS[1]],
            [b"", b"  ", TEXTS[0][:9], TEXTS[0][:-1]],
        )
    ),
)
def test_lines_that_are_read_many_at_once_are_read_as_one_by_one(
    path: Path, header: bytes, block_bytes: int, end: bytes, between: bytes
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lab_log, "BLOCK_BYTES", block_bytes)
        lines, flaws = through(path, header + TEXTS[0] + between + b"".join(TEXTS[1:]) + end)
    assert lines == LINES
    assert len(flaws) == between.count(b"\n") + bool(end)


def test_a_last_line_without_a_newline_is_torn(path: Path, header: bytes) -> None:
    lines, flaws = through(path, (header + b"".join(TEXTS))[:-1])
    assert lines == LINES[:-1]
    assert flaws[0] == "line 5 is torn: dropped"


def test_numbers_out_of_order_are_reported_even_with_equal_times(path: Path, header: bytes) -> None:
    same_time = [line(source, msgspec.structs.replace(entry, t_s=5.0)) for source, entry in LINES]
    _, flaws = through(path, header + b"".join([same_time[1], same_time[0], *same_time[2:]]))
    assert flaws == ("r1: entry 1 of t=5.0 s comes after entry 2 of t=5.0 s",)


def test_a_line_edited_by_hand_is_reported_even_if_its_number_is_there(path: Path, header: bytes) -> None:
    edited = TEXTS[0].replace(b"1.0}", b'"far"}')
    lines, flaws = through(path, header + b"".join([edited, *TEXTS[1:]]))
    assert lines == LINES[1:]
    assert [flaw.split(" - at ")[1] for flaw in flaws] == ["`$.behind_m`"]


def test_a_line_without_an_end_takes_bounded_memory(
    path: Path, header: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lab_log, "LINE_BYTES_MAX", len(header))
    lines, flaws = through(path, header + b"x" * (5 * len(header) + 7) + b"\n" + b"".join(TEXTS))
    assert lines == LINES
    assert flaws == (f"line 2 is longer than {len(header)} bytes: dropped",)


def test_known_entries_of_a_newer_schema_are_read(path: Path, header: bytes) -> None:
    newer = header.replace(b"clew-timeline/1", b"clew-timeline/2").replace(b'"run":', b'"fleet":"f","run":')
    texts = [
        TEXTS[0].replace(b"behind_m", b'mood":"good","behind_m'),
        TEXTS[1].replace(b"robot.released", b"robot.sneezed"),
        TEXTS[2].replace(b"robot.held", b"robot.sneezed"),
        TEXTS[3],
    ]
    lines, flaws = through(path, newer + b"".join(texts))
    assert lines == [LINES[0], LINES[3]]
    assert flaws == (
        "its schema is 'clew-timeline/2', this program reads 'clew-timeline/1': only what both know is shown",
        "2 entries of a kind that this program does not know: 'robot.sneezed'",
    )


def test_an_unknown_schema_is_refused_by_name(path: Path) -> None:
    path.write_bytes(b'{"kind":"run.started","schema":"clew-timeline/9"}\n')
    with pytest.raises(UsageError, match=r"its schema is 'clew-timeline/9'.*its header cannot be read"):
        Log(path)


def test_a_log_with_its_header_cut_off_is_read_without_it(path: Path) -> None:
    lines, flaws = through(path, b"".join(TEXTS))
    assert lines == LINES
    (flaw,) = flaws
    assert "the first line is no header of a run" in flaw
    assert Log(path).header == UNKNOWN


@pytest.mark.parametrize("damage", [b"?", b"", b"\xff", b"{}", b"[1]", b'{"kind":"robot.held"}'])
def test_a_log_with_a_damaged_header_is_read_without_it(path: Path, damage: bytes) -> None:
    lines, (flaw,) = through(path, damage + b"\n" + b"".join(TEXTS))
    assert lines == LINES
    assert "the first line is no header of a run" in flaw
    assert Log(path).header == UNKNOWN


def test_the_rest_of_a_header_edited_by_hand_is_known(path: Path, header: bytes) -> None:
    lines, (flaw,) = through(path, header.replace(b'"seed":1', b'"seed":"one"') + b"".join(TEXTS))
    assert lines == LINES
    assert "Expected `int`, got `str` - at `$.seed`; what it lacks is unknown" in flaw
    assert Log(path).header == msgspec.structs.replace(HEADER, seed=0)


def test_a_header_of_another_program_is_refused_by_name(path: Path, header: bytes) -> None:
    path.write_bytes(header.replace(b"clew-timeline/1", b"rosbag/2"))
    with pytest.raises(UsageError, match="its schema is 'rosbag/2', this program reads 'clew-timeline/1'"):
        Log(path)


@pytest.mark.parametrize(
    "content",
    [b"\n", b"hello\n", b'{"kind":"run.started"}\n', b'{"t_s":1.0}\n', b"\xff\xfe\n", b"[" * 100_000],
)
def test_a_file_that_is_no_log_is_refused(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(UsageError, match="the first line is no header of a run"):
        timeline.read(path)


def test_an_empty_file_is_refused_as_empty(path: Path) -> None:
    path.write_bytes(b"")
    with pytest.raises(UsageError, match="it is empty: no header of a run"):
        Log(path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=f"no run in {tmp_path}/nowhere: No such file or directory"):
        Log(tmp_path / "nowhere")


def test_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no run in .*events\.jsonl"):
        timeline.read(tmp_path)


def test_a_header_alone_is_a_log_without_an_end(path: Path, header: bytes) -> None:
    assert through(path, header) == ([], ("no run.ended: the world died before it could end the run",))


def test_the_first_of_many_flaws_are_listed_and_the_rest_is_counted(path: Path, header: bytes) -> None:
    _, flaws = through(path, header + b"?\n" * 1000 + b"".join(TEXTS))
    assert len(flaws) == TOLD_MAX + 1
    assert flaws[-1] == f"and {1000 - TOLD_MAX} more like these"


def test_reading_a_log_again_gives_the_same(path: Path, header: bytes) -> None:
    path.write_bytes(header + b"".join(TEXTS[1:]))
    log = Log(path)
    assert (list(log.lines), log.flaws) == (list(log.lines), log.flaws)
    assert log.ended == "interrupted"
    assert list(log.lines) == LINES[1:]
    assert log.header == HEADER


@given(st.lists(st.integers(1, 12), max_size=14))
def test_numbers_find_what_is_missing_and_what_is_doubled(seen: list[int]) -> None:
    numbers = Numbers()
    for number in seen:
        numbers.add(number)
    flaws = list(numbers.flaws())
    newest = max(seen, default=0)
    holes = [number for number in range(1, newest) if number not in seen]
    missing = [
        f"{len(holes)} of {newest} entries are missing, the first is number {first}" for first in holes[:1]
    ]
    assert [flaw for flaw in flaws if "missing" in flaw] == missing
    assert any("more than once" in flaw for flaw in flaws) == (len(set(seen)) < len(seen))


@pytest.mark.parametrize("verb", [["log", "check"], ["log", "cat"], ["log", "cat", "--follow"], ["report"]])
def test_a_log_that_is_no_regular_file_is_refused_at_once(tmp_path: Path, verb: list[str]) -> None:
    os.mkfifo(tmp_path / EVENTS_FILE)
    said = clew(*verb, tmp_path)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert "no regular file" in said.stderr
