"""The page of figures: the missed aims first, then every result."""

import math
from pathlib import Path

import msgspec
from msgspec.structs import replace

from clew.bench.machine import cpu_model
from clew.bench.page import page
from clew.bench.result import Aim, Machine, Result, figure
from tests.support.campaigns import clew

HOP = Result(
    benchmark="hop",
    command="clew bench hop --json",
    about="How long.",
    at="2026-11-23",
    machine=Machine(cpu="Chip", cores=2, memory_mb=8000, kernel="6.1", load=1.5),
    versions={"Python": "3.11"},
    figures=(
        figure(
            "5 robots",
            "us",
            [130.0, 150.0, 140.0],
            baselines={"asyncio": [100.0] * 3, "callback": [70.0] * 3},
            aim=Aim(of="asyncio", at_most=1.3),
        ),
        figure("50 robots", "us", [0.01], aim=Aim(at_most=1.0)),
    ),
)


def test_a_missed_aim_stands_before_all_results_with_what_was_reached() -> None:
    before, after = page([HOP]).split("## `clew bench hop`")
    assert "1 of 2 aims are missed." in before
    assert "| `hop` | 5 robots | 1.4 (1.3 to 1.5) | at most 1.3 of asyncio |" in before
    assert "| 5 robots | us | 140 (130 to 150) | asyncio: 100 (100 to 100) | 1.4 (1.3 to 1.5) |" in after
    assert "**missed** |" in after


def test_each_further_baseline_has_a_row() -> None:
    assert "| callback: 70 (70 to 70) | 2 (1.86 to 2.14) |" in page([HOP])


def test_a_time_that_is_missing_never_came_and_another_figure_was_not_measured() -> None:
    late = figure("formed", "s", [math.inf], aim=Aim(at_most=20.0))
    memory = figure("memory", "MB", [math.inf], aim=Aim(at_most=5.0))
    before, after = page([replace(HOP, figures=(late, memory))]).split("## `clew bench hop`")
    assert "| `hop` | formed | never | at most 20 |" in before
    assert "| `hop` | memory | not measured | at most 5 |" in before
    assert "| memory | MB | not measured |" in after


def test_of_an_aim_for_each_repeat_the_worst_one_is_told() -> None:
    late = figure("order", "s", [0.1, 0.2, 0.9], aim=Aim(at_most=0.5, each=True))
    never = figure("heal", "s", [0.1, math.inf], aim=Aim(each=True))
    before, _ = page([replace(HOP, figures=(late, never))]).split("## `clew bench hop`")
    assert "| `hop` | order | 0.9 s | each at most 0.5 |" in before
    assert "| `hop` | heal | never | each to come |" in before


def test_the_page_says_machine_versions_command_and_load() -> None:
    said = page([HOP])
    for words in ("Chip, 2 cores, 8 GB, Linux 6.1; load 1.5", "Python 3.11", "`clew bench hop --json`"):
        assert words in said


def test_without_a_missed_aim_there_is_no_table_of_misses() -> None:
    good = replace(HOP, figures=HOP.figures[1:])
    assert "0 of 1 aims are missed.\n\n## `clew" in page([good])


def test_the_verb_writes_the_page_of_results(tmp_path: Path) -> None:
    (tmp_path / "hop.json").write_bytes(msgspec.json.encode(HOP))
    for _ in range(2):
        told = clew("bench", "page", tmp_path / "hop.json", "--out", tmp_path / "page.md")
        assert told.exit_code == 0, told.output
        assert (tmp_path / "page.md").read_text(encoding="utf-8") == page([HOP])


def test_the_verb_replaces_no_file_but_such_a_page(tmp_path: Path) -> None:
    (tmp_path / "hop.json").write_bytes(msgspec.json.encode(HOP))
    (tmp_path / "notes.md").write_bytes(b"# Performance\n\nMy notes \xff.\n")
    told = clew("bench", "page", tmp_path / "hop.json", "--out", tmp_path / "notes.md")
    refusal = f"cannot write {tmp_path}/notes.md: it is there, and bears no mark of Clew, so it would be lost"
    assert (told.exit_code, told.stderr) == (2, f"Error: {refusal}\n")
    assert (tmp_path / "notes.md").read_bytes().startswith(b"# Performance\n\nMy notes")


def test_the_verb_refuses_what_is_no_result(tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text("{}", encoding="utf-8")
    told = clew("bench", "page", tmp_path / "other.json", "--out", tmp_path / "page.md")
    assert (told.exit_code, told.stderr.count("\n")) == (2, 1)


def test_a_page_that_cannot_be_written_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "hop.json").write_bytes(msgspec.json.encode(HOP))
    told = clew("bench", "page", tmp_path / "hop.json", "--out", tmp_path)
    assert (told.exit_code, told.stderr) == (2, f"Error: cannot write {tmp_path}: Is a directory\n")


def test_the_model_of_the_processor_is_read_from_what_linux_tells() -> None:
    assert cpu_model("processor\t: 0\nmodel name\t: Chip 9\n") == "Chip 9"
    assert cpu_model("processor\t: 0\n") != ""
