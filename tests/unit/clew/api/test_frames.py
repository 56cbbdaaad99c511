"""Tables of a run, in each library that is installed."""

from typing import Any

import msgspec
import pytest

from clew.api.frames import DICTS, columns_of, frame_of
from clew.api.run import Run, open_run
from protocol.errors import UsageError
from protocol.timeline import KINDS
from tests.support.runs import Runs

NAMED = ("poses", "steps", "messages", "faults", "states", "waits", "entries")


@pytest.fixture
def run(runs: Runs) -> Run:
    """To read."""
    return open_run(runs.of("grove", faults="leader-killed"))


@pytest.mark.parametrize("name", [*NAMED, *KINDS])
def test_every_table_has_rows_of_one_length(run: Run, name: str) -> None:
    rows = run.frame(name, to=DICTS)
    assert all(row.keys() == rows[0].keys() for row in rows)
    assert rows or name not in NAMED


def test_a_table_of_a_kind_has_the_entries_of_that_kind(run: Run) -> None:
    rows = run.frame("step.planned", to=DICTS)
    told = [entry.as_dict() for entry in run.entries("step.planned")]
    plain = [{name: value for name, value in entry.items() if name != "kind"} for entry in told]
    assert msgspec.to_builtins(rows) == plain


def test_steps_tell_what_became_of_them(run: Run) -> None:
    rows = run.frame("steps", to=DICTS)
    assert [row["how"] for row in rows].count("finished") == len(run.entries("step.finished"))
    assert all(row["planned_s"] <= row["ended_s"] for row in rows)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_frame_has_the_columns_of_the_dicts(run: Run, library: str) -> None:
    pytest.importorskip(library)
    for name in NAMED:
        frame: Any = run.frame(name, to=library)
        rows = run.frame(name, to=DICTS)
        assert list(frame.columns) == list(rows[0])
        assert len(frame) == len(rows)
    poses: Any = run.frame("poses", to=library)
    assert poses["clearance_m"].min() == min(row["clearance_m"] for row in run.frame("poses", to=DICTS))


def test_a_table_or_a_library_that_is_not_there_is_refused(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match=r"or a kind of entry, got 'pose'; did you mean 'poses'"):
        run.frame("pose")
    with pytest.raises(UsageError, match="to must be one of pandas, polars, dicts, got numpy"):
        run.frame("poses", to="numpy")
    monkeypatch.setattr("clew.api.frames.find_spec", lambda _: None)
    with pytest.raises(UsageError, match="frame: polars is not installed; to='dicts' needs no library"):
        run.frame("poses", to="polars")
    with pytest.raises(
        UsageError, match=r"frame: pandas is not installed \(it is in the extra `frames`\); to="
    ):
        run.frame("poses", to="pandas")


def test_a_run_without_entries_has_tables_without_rows_and_with_all_columns(run: Run) -> None:
    for name in NAMED:
        full, none = columns_of(name, run._reading.lines, lambda: run.messages), columns_of(name, [], list)
        assert list(none) == list(full)
        assert not any(none.values())
        assert frame_of(none, DICTS) == []
