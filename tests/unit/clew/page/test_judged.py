"""The verdict beside a log: an invalid one never reaches the page, and one of another log is reported."""

import json
from pathlib import Path
from typing import Any

import pytest

from clew.page.judged import SAME_M
from tests.support.pages.pages import told
from tests.support.runs import Runs
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE


@pytest.fixture(scope="module")
def whole(runs: Runs) -> Path:
    return runs.of("pedestrian")


@pytest.fixture
def run(whole: Path, tmp_path: Path) -> Path:
    """A run whose verdict the test may edit."""
    for name in (EVENTS_FILE, VERDICT_FILE):
        (tmp_path / name).write_bytes((whole / name).read_bytes())
    return tmp_path


def edit(run: Path, **fields: object) -> dict[str, Any]:
    """The original verdict."""
    path = run / VERDICT_FILE
    before: dict[str, Any] = json.loads(path.read_bytes())
    path.write_text(json.dumps(before | fields), encoding="utf-8")
    return before


def flaws_of(run: Path) -> list[str]:
    *_, batch = told(run)
    flaws: list[str] = batch.get("flaws", [])
    return flaws


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("path_m", "7"),
        ("clearance_m_min", "abc"),
        ("robots", None),
        ("deaths", 3),
        ("messages", {"sent": 1}),
        ("reason", ["no"]),
        ("violations_by_invariant", {"S1": "many"}),
    ],
)
def test_an_invalid_verdict_is_reported_and_not_shown(run: Path, field: str, value: object) -> None:
    edit(run, **{field: value})
    batches = told(run)
    assert all("verdict" not in batch for batch in batches)
    [flaw] = batches[-1]["flaws"]
    assert flaw.startswith(f"{VERDICT_FILE} cannot be read: ")
    assert f"$.{field}" in flaw


def test_a_verdict_that_is_no_file_is_reported_without_its_path(run: Path) -> None:
    (run / VERDICT_FILE).unlink()
    (run / VERDICT_FILE).mkdir()
    assert f"{VERDICT_FILE} cannot be read: Is a directory" in told(run)[-1]["flaws"]


def test_the_verdict_of_a_complete_log_agrees_with_it(run: Path) -> None:
    assert flaws_of(run) == []


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("field", "name"),
    [
        ("clearance_m_min", "clearance"),
        ("moving_clearance_m_min", "clearance of what moves"),
        ("separation_m_min", "separation"),
    ],
)
def test_distances_of_another_log_are_reported(run: Path, field: str, name: str, sign: float) -> None:
    here_m = json.loads((run / VERDICT_FILE).read_bytes())[field]
    edit(run, **{field: here_m + sign * 3 * SAME_M})
    [flaw] = flaws_of(run)
    assert flaw.startswith(
        f"the log's own poses say a least {name} of {here_m:.4f} m, and {VERDICT_FILE} says "
    )
    assert flaw.endswith("the verdict is not of this log")
    edit(run, **{field: here_m + sign * 0.5 * SAME_M})
    assert flaws_of(run) == []


@pytest.mark.parametrize("more", [-1, 1])
def test_steps_of_another_log_are_reported(run: Path, more: int) -> None:
    steps = json.loads((run / VERDICT_FILE).read_bytes())["switching_steps"]
    edit(run, switching_steps=steps + more)
    [flaw] = flaws_of(run)
    assert flaw.startswith(
        f"the log's own entries say {steps} switching steps, and {VERDICT_FILE} says {steps + more}"
    )


def test_for_a_log_without_its_end_only_worse_values_are_a_contradiction(run: Path) -> None:
    events = run / EVENTS_FILE
    lines = events.read_bytes().splitlines(keepends=True)
    events.write_bytes(b"".join(lines[: len(lines) // 3]) + b'{"torn')
    before = edit(run)
    assert [flaw for flaw in flaws_of(run) if "not of this log" in flaw] == []
    edit(run, separation_m_min=before["separation_m_min"] + 1.0)
    assert len([flaw for flaw in flaws_of(run) if "not of this log" in flaw]) == 1
