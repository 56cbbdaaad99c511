import json
from dataclasses import replace
from pathlib import Path

import pytest

from clew.log import timeline
from clew.log.timeline import Choice
from protocol.frames import Point
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FaultInjected,
    LeaderSucceeded,
    PoseSampled,
    Record,
    RobotReleased,
    RobotStarted,
    RunEnded,
    StrandDissolved,
)
from tests.support.logs.logs import HEADER, numbered, recorded
from tests.support.strands import ordered
from world.record.lines import Line
from world.record.recorder import line

RECORDS: tuple[tuple[str, Record], ...] = (
    ("r1", RobotStarted(pid=4711)),
    ("world", PoseSampled(robot=1, x_m=0.0, y_m=0.5, heading_rad=0.1)),
    (
        "world",
        ordered(1, epoch=1, step=3, y_m=0.5, target=Point(x_m=1.0, y_m=0.0), reach_m=1.5),
    ),
    ("r1", AuthorityGranted(to=2, epoch=1, authority_m=0.4)),
    ("world", RunEnded(reason="all robots have arrived")),
)


def lines_of() -> list[Line]:
    return numbered(RECORDS)


def rewritten(folder: Path, texts: list[bytes]) -> Path:
    header = (recorded(folder, []) / "events.jsonl").read_bytes()
    (folder / "events.jsonl").write_bytes(header + b"".join(texts))
    return folder


def test_everything_that_the_recorder_wrote_is_read_back(tmp_path: Path) -> None:
    read = timeline.read(recorded(tmp_path / "run", lines_of()))
    assert read.header == HEADER
    assert list(read.lines) == lines_of()
    assert read.flaws == ()


def test_a_run_is_its_folder_or_its_events_file(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", lines_of())
    assert timeline.read(run) == timeline.read(run / "events.jsonl")


def test_entry_twice_is_a_flaw(tmp_path: Path) -> None:
    texts = [line(source, entry) for source, entry in lines_of()]
    read = timeline.read(rewritten(tmp_path / "run", [texts[0], *texts]))
    assert read.flaws == ("r1: entry 1 is in the log more than once",)


def test_a_restarted_robot_counts_from_one_and_a_hole_in_either_process_is_a_flaw(
    tmp_path: Path,
) -> None:
    second = [
        ("r1", Entry(n=1, t_s=0.0, hlc="later", record=RobotStarted(pid=2))),
        ("r1", Entry(n=2, t_s=9.0, hlc="later", record=RobotReleased())),
    ]
    lines = [*lines_of()[:-1], *second, lines_of()[-1]]
    whole = timeline.read(rewritten(tmp_path / "run", [line(*each) for each in lines]))
    assert whole.flaws == ()
    lines[-2] = ("r1", Entry(n=3, t_s=9.0, hlc="later", record=RobotReleased()))
    short = timeline.read(rewritten(tmp_path / "short", [line(*each) for each in lines]))
    assert short.flaws == ("r1: 1 of 3 entries are missing, the first is number 2",)


EVERYTHING = Choice()


@pytest.mark.parametrize(
    ("choice", "chosen"),
    [
        (EVERYTHING, [0, 1, 2, 3, 4]),
        (replace(EVERYTHING, source=("r1",)), [0, 3]),
        (replace(EVERYTHING, kind=("robot.*",)), [0]),
        (replace(EVERYTHING, kind=("pose.sampled",)), [1]),
        (replace(EVERYTHING, kind=("pose.sampled", "robot.*"), source=("r1", "world")), [0, 1]),
        (replace(EVERYTHING, robot=1), [0, 1, 2, 3]),
        (replace(EVERYTHING, robot=2), [3]),
        (replace(EVERYTHING, step=3), [2]),
        (replace(EVERYTHING, from_s=1.0, to_s=2.0), [1, 2]),
        (replace(EVERYTHING, robot=1, source=("world",)), [1, 2]),
    ],
)
def test_a_choice_takes_exactly_the_named_entries(choice: Choice, chosen: list[int]) -> None:
    lines = lines_of()
    assert [index for index, (source, entry) in enumerate(lines) if choice.takes(source, entry)] == chosen


@pytest.mark.parametrize(
    "record",
    [
        FaultInjected(fault="kill", rule="kill-1", process="r3"),
        StrandDissolved(epoch=1, blocked=3),
        LeaderSucceeded(epoch=2, before=3),
    ],
)
def test_entries_about_a_robot_are_chosen_with_its_own(record: Record) -> None:
    entry = Entry(n=1, t_s=0.0, hlc="0/0", record=record)
    assert Choice(robot=3).takes("r1", entry)
    assert not Choice(robot=2).takes("r1", entry)


def test_the_header_line_has_its_kind(tmp_path: Path) -> None:
    first = (recorded(tmp_path / "run", []) / "events.jsonl").read_bytes().splitlines()[0]
    assert json.loads(first)["kind"] == "run.started"


def test_an_old_log_without_a_fault_plan_in_its_header_is_read(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", lines_of())
    first, *rest = (run / "events.jsonl").read_bytes().splitlines(keepends=True)
    old = {name: value for name, value in json.loads(first).items() if name != "faults"}
    (run / "events.jsonl").write_bytes(json.dumps(old).encode() + b"\n" + b"".join(rest))
    assert (timeline.read(run).header.faults, list(timeline.read(run).lines)) == (None, lines_of())
