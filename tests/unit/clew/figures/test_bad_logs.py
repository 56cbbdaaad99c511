"""Figures of damaged logs and of folders that are no run: the flaw is reported, the rest is drawn."""

import re
import sys
from pathlib import Path

import pytest

from clew.verbs.extras import install_line
from tests.support.campaigns import clew
from tests.support.logs.logs import AT_REST, numbered, recorded
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE


def test_a_torn_line_and_a_newer_schema_are_reported_and_the_rest_is_drawn(
    runs: Runs, tmp_path: Path
) -> None:
    text = (runs.of("paper") / EVENTS_FILE).read_bytes()
    newer = tmp_path / EVENTS_FILE
    newer.write_bytes(text[: len(text) // 2].replace(b"clew-timeline/1", b"clew-timeline/2", 1))
    told = clew("figures", newer, "--format", "svg")
    assert told.exit_code == 0
    assert re.search(r"not complete: line \d+ is torn", told.stderr)
    assert "clew-timeline/2" in told.stderr
    assert len(told.stdout.splitlines()) == 5


def test_with_a_damaged_header_everything_that_entries_alone_tell_is_drawn(
    runs: Runs, tmp_path: Path
) -> None:
    _, entries = (runs.of("grove", faults="leader-killed") / EVENTS_FILE).read_bytes().split(b"\n", 1)
    headless = tmp_path / EVENTS_FILE
    headless.write_bytes(b'{"kind": "run.started", "sche\n' + entries)
    told = clew("figures", headless, "--format", "svg")
    assert told.exit_code == 0
    assert "not complete: line 1 is damaged" in told.stderr
    assert "not drawn: clearance: the log does not say where obstacles were" in told.stderr
    assert {Path(line).stem for line in told.stdout.splitlines()} == {"region", "steps", "separation"}
    assert "required" not in (tmp_path / "figures" / "separation.svg").read_text(encoding="utf-8")
    checked = clew("log", "check", headless)
    assert checked.exit_code == 2
    assert "line 1, the header, is damaged" in checked.stderr


def test_a_run_without_motion_has_no_distances_and_the_rest_is_drawn(tmp_path: Path) -> None:
    told = clew("figures", recorded(tmp_path / "run", numbered(AT_REST)), "--format", "svg")
    assert told.exit_code == 0
    assert "not drawn: distances: the leader has not begun a switching step\n" in told.stderr
    drawn = {Path(line).stem for line in told.stdout.splitlines()}
    assert drawn == {"region", "clearance", "separation"}


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("empty/", None, "neither a run (events.jsonl) nor a campaign (campaign.json)"),
        ("nothing", None, "there is no such run or campaign"),
        ("notes.txt", "hello", "no header of a run"),
        ("campaign.json", "{}", "no campaign that this program can read"),
        ("campaign.json", '{"episodes": 3}', "no campaign that this program can read"),
    ],
)
def test_a_source_that_is_neither_run_nor_campaign_is_refused_in_one_line_also_without_matplotlib(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, content: str | None, why: str
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    path = tmp_path / name
    if name.endswith("/"):
        path.mkdir()
    elif content is not None:
        path.write_text(content, encoding="utf-8")
    told = clew("figures", path)
    assert told.exit_code == 2
    assert why in told.stderr
    assert (len(told.stderr.splitlines()), told.stdout) == (1, "")


def test_an_unknown_format_and_a_folder_that_is_a_file_are_refused(runs: Runs) -> None:
    for option, value in (("--format", "svg,gif"), ("--out", str(runs.of("paper") / EVENTS_FILE))):
        told = clew("figures", runs.of("paper"), option, value)
        assert told.exit_code == 2
        assert len(told.stderr.splitlines()) == 1


def test_without_matplotlib_a_line_names_the_extra(runs: Runs, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    told = clew("figures", runs.of("paper"))
    assert told.exit_code == 2
    assert install_line("plot") in told.stderr
