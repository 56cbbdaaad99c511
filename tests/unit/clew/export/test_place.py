"""An export is written completely or not at all, and never replaces anything but an export."""

import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.writer import Writer

from clew.export import place
from clew.export.mcap_file import MARK
from clew.export.place import whole_file, whole_folder
from protocol.errors import UsageError
from protocol.root import ROOT
from protocol.timeline import RunEnded
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import numbered, recorded


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return recorded(tmp_path / "run", numbered((("world", RunEnded(reason="done")),)))


def interrupted(draft: Path) -> None:
    draft.write_text("half")
    raise KeyboardInterrupt


def test_an_unfinished_file_leaves_nothing(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "events.mcap"
    with pytest.raises(KeyboardInterrupt), whole_file(out, MARK) as draft:
        interrupted(draft)
    assert list(out.parent.iterdir()) == []


def test_an_export_that_is_interrupted_as_it_begins_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def made(folder: Path) -> None:
        folder.mkdir()
        raise KeyboardInterrupt

    monkeypatch.setattr(place, "make_folder", made)
    with pytest.raises(KeyboardInterrupt), whole_file(tmp_path / "events.mcap", MARK):
        pass
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_file_stays_until_the_new_one_is_complete(tmp_path: Path) -> None:
    out = tmp_path / "events.mcap"
    out.write_bytes(b"old" + MARK)
    with whole_file(out, MARK) as draft:
        draft.write_bytes(b"new")
        assert out.read_bytes() == b"old" + MARK
    assert out.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [out]


def test_an_earlier_folder_stays_until_the_new_one_is_complete(tmp_path: Path) -> None:
    out = tmp_path / "csv"
    for text in ("old", "new"):
        with whole_folder(out, {"old.csv", "new.csv"}) as draft:
            (draft / f"{text}.csv").write_text(text)
            assert [each.name for each in out.glob("*")] == (["old.csv"] if text == "new" else [])
    assert [each.name for each in out.iterdir()] == ["new.csv"]
    with pytest.raises(KeyboardInterrupt), whole_folder(out, {"old.csv", "new.csv"}) as draft:
        interrupted(draft / "half.csv")
    assert [each.name for each in out.iterdir()] == ["new.csv"]
    assert list(tmp_path.iterdir()) == [out]


def test_a_recording_of_another_program_is_not_replaced_but_an_earlier_export_is(
    run: Path, tmp_path: Path
) -> None:
    out = tmp_path / "bag.mcap"
    bag = Writer(str(out))
    bag.start(profile="ros2")
    bag.finish()  # type: ignore[no-untyped-call] # of the library
    before = out.read_bytes()
    said = clew("log", "export", run, "--to", "mcap", "--out", out)
    assert (said.exit_code, said.stderr) == (
        2,
        f"Error: cannot write {out}: it is there, and bears no mark of Clew, so it would be lost\n",
    )
    assert out.read_bytes() == before
    out.write_bytes(b"")  # as mktemp makes it
    for _ in range(2):
        assert clew("log", "export", run, "--to", "mcap", "--out", out).exit_code == 0


def test_a_folder_with_foreign_files_is_not_replaced(run: Path) -> None:
    holds = "it holds events.jsonl, which is not part of an earlier export and would be lost"
    for out, why in ((run, holds), (run / "events.jsonl", "it is no folder, and this export is one")):
        said = clew("log", "export", run, "--to", "csv", "--out", out)
        assert (said.exit_code, said.stderr) == (2, f"Error: {out}: {why}\n")
    assert (run / "events.jsonl").stat().st_size > 0


def test_a_refusal_names_the_place_and_no_option_that_nobody_has_given(run: Path) -> None:
    (run / "csv").mkdir()
    (run / "csv" / "notes.txt").touch()
    said = clew("log", "export", run, "--to", "csv")
    assert (said.exit_code, said.stderr.partition(" it holds notes.txt")[0]) == (2, f"Error: {run}/csv:")


def test_a_folder_of_the_users_own_tables_is_not_replaced_but_an_earlier_export_is(
    run: Path, tmp_path: Path
) -> None:
    own = tmp_path / "mydata"
    own.mkdir()
    (own / "precious.csv").write_text("a,b")
    said = clew("log", "export", run, "--to", "csv", "--out", own)
    assert said.exit_code == 2
    assert "it holds precious.csv, which is not part of an earlier export" in said.stderr
    assert [each.name for each in own.iterdir()] == ["precious.csv"]
    for _ in range(2):
        assert clew("log", "export", run, "--to", "csv", "--out", tmp_path / "out").exit_code == 0


def test_the_next_export_removes_only_the_leftovers_of_a_killed_one(run: Path, tmp_path: Path) -> None:
    left, own = tmp_path / ".out.dead.part", tmp_path / ".out.own.part"
    for folder, name in ((left, "new"), (own, "diary.txt")):
        folder.mkdir()
        (folder / name).touch()
    out = tmp_path / "out"
    with whole_folder(out, {"pose.sampled.csv"}) as living:
        assert clew("log", "export", run, "--to", "csv", "--out", out).exit_code == 0
        assert living.is_dir()
    assert {each.name for each in tmp_path.iterdir()} == {"run", "out", own.name}


# The export interrupts itself in its middle: from outside nobody can be sure to be in time.
INTERRUPTS_ITSELF = """
import signal, sys
from pathlib import Path
from clew.cli import main
from clew.export import csv_files, mcap_file
number = int(sys.argv.pop())
def interrupts(*_):
    assert list(Path(RUN).glob(".*.part")), "there is a draft"
    signal.raise_signal(number)
csv_files.fill = mcap_file._Writing.entry = interrupts
main()
"""


@pytest.mark.processes
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("to", ["mcap", "csv"])
def test_an_interrupted_export_leaves_nothing(run: Path, to: str, number: signal.Signals) -> None:
    asked = ["log", "export", str(run), "--to", to, str(int(number))]
    script = INTERRUPTS_ITSELF.replace("RUN", repr(str(run)))
    ended = subprocess.run([sys.executable, "-c", script, *asked], cwd=ROOT, timeout=DEADLINE_S, check=False)
    assert ended.returncode == 128 + number
    assert [each.name for each in run.iterdir()] == ["events.jsonl"]


def test_an_export_never_overwrites_its_own_log(run: Path) -> None:
    said = clew("log", "export", run, "--to", "mcap", "--out", run / "events.jsonl")
    assert said.exit_code == 2
    assert "its name must end in .mcap" in said.stderr
    (run / "folder.mcap").mkdir()
    assert clew("log", "export", run, "--to", "mcap", "--out", run / "folder.mcap").exit_code == 2


def test_an_unwritable_place_is_reported_in_one_line(tmp_path: Path, run: Path) -> None:
    (tmp_path / "file").write_text("")
    said = clew("log", "export", run, "--to", "csv", "--out", tmp_path / "file" / "csv")
    assert said.exit_code == 2
    assert said.stderr == f"Error: {tmp_path}/file/csv: cannot be written: {tmp_path}/file is no folder\n"
    with pytest.raises(UsageError, match="No space left"), whole_file(tmp_path / "full.mcap", MARK):
        Path("/dev/full").write_bytes(b"more than fits")


@pytest.mark.parametrize("to", ["mcap", "csv", "parquet"])
def test_an_export_that_does_not_fit_is_one_line_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Path, to: str
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # of a library loaded now, half would be kept
    out = tmp_path / "out" / f"export.{to}"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        said = clew("log", "export", run, "--to", to, "--out", out)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert said.stderr.startswith(f"Error: {out}: cannot be written: ")
    assert list(out.parent.iterdir()) == []


@pytest.mark.parametrize("to", ["csv", "mcap", "parquet"])
def test_a_folder_without_a_run_is_refused_also_without_the_library_of_the_export(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, to: str
) -> None:
    for library in ("foxglove", "pyarrow"):
        monkeypatch.setitem(sys.modules, library, None)
    said = clew("log", "export", tmp_path, "--to", to)
    assert said.exit_code == 2
    assert said.stderr.startswith(f"Error: no run in {tmp_path}: events.jsonl: ")
    assert list(tmp_path.iterdir()) == []
