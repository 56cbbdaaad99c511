"""`clew ls`: what it says of runs, and what it does not delete."""

import json
import os
import socket
from datetime import UTC, datetime
from pathlib import Path

import pytest
from click.testing import CliRunner

from clew.cli import main
from clew.fleet import runs
from clew.fleet.folder import make_latest
from protocol.faults.manual_faults import WHERE_FILE
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from world.record.run_files import save_verdict

HOUR_S = 3600.0
QUIET_S = 2.0 * DEADLINE_S  # in place of the 10 s of the product: half of it is longer than a test takes


@pytest.fixture(autouse=True)
def cwd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    return tmp_path


def run(name: str, *, age_s: float = HOUR_S, verdict: bool = True) -> Path:
    """A run of this age in runs/."""
    folder = recorded(Path("runs") / name, numbered(AT_REST))
    if verdict:
        save_verdict(GOOD, folder)
    written_s = datetime.now(UTC).timestamp() - age_s
    for path in (*folder.rglob("*"), folder):
        os.utime(path, (written_s, written_s))
    return folder


def test_runs_are_listed_with_verdict_size_and_age_the_newest_first() -> None:
    run("old", age_s=49.0 * HOUR_S, verdict=False)
    make_latest(run("new"))
    Path("runs/campaign-1").mkdir()
    head, *rows = clew("ls").stdout.splitlines()
    assert head.split() == ["run", "verdict", "size", "age"]
    assert [row.split()[0] for row in rows] == ["runs/new", "runs/old"]
    assert f"OK: {GOOD.reason}" in rows[0]
    assert rows[0].split()[-2:] == ["1", "h"]
    assert "no verdict" in rows[1]
    assert rows[1].split()[-4:] == ["0.0", "MB", "2", "d"]
    assert [each["run"] for each in json.loads(clew("ls", "--json").stdout)] == ["runs/new", "runs/old"]


def test_without_a_run_one_line_says_so() -> None:
    said = clew("ls")
    assert (said.exit_code, said.stdout, said.stderr) == (0, "", "no run in runs/\n")


@pytest.mark.parametrize(("answer", "is_there"), [("n\n", True), ("", True), ("y\n", False)])
def test_deleting_asks_first(answer: str, *, is_there: bool) -> None:
    folder = run("one")
    said = CliRunner().invoke(main, ["ls", str(folder), "--delete"], input=answer)
    assert "Delete this run, 0.0 MB? [y/N]" in said.stderr
    assert folder.exists() == is_there
    assert (said.exit_code == 1) == is_there


def test_deleting_without_a_question_takes_only_what_is_named_and_the_link_to_it() -> None:
    other, latest = run("other"), run("latest-one")
    make_latest(latest)
    assert clew("ls", "runs/latest", "--delete", "--yes").exit_code == 0
    assert sorted(Path("runs").iterdir()) == [other]
    assert clew("ls", "--delete", "--yes").exit_code == 2, "it names no run"
    assert other.exists()


def test_a_live_run_that_goes_on_is_not_deleted_and_nothing_else_is() -> None:
    ended, live = run("ended"), run("live", verdict=False)
    with socket.socket(socket.AF_UNIX) as world:
        world.bind("w.sock")
        world.listen()
        (live / WHERE_FILE).write_text("w.sock", encoding="utf-8")
        said = clew("ls", ended, live, "--delete", "--yes")
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert "runs/live: the run goes on" in said.stderr
    assert ended.exists()
    assert live.exists()


def test_a_run_without_a_verdict_goes_on_as_long_as_it_is_written_to(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(runs, "QUIET_S", QUIET_S)
    begun = run("begun", age_s=QUIET_S / 2.0, verdict=False)
    assert "going on" in clew("ls").stdout
    assert clew("ls", begun, "--delete", "--yes").exit_code == 2
    assert begun.exists()
    dead = run("dead", age_s=2.0 * QUIET_S, verdict=False)
    assert clew("ls", dead, "--delete", "--yes").exit_code == 0
    assert not dead.exists()


@pytest.mark.parametrize("content", [b"", b"{", b'{"ok": 1}'])
def test_a_run_whose_verdict_cannot_be_read_is_over(monkeypatch: pytest.MonkeyPatch, content: bytes) -> None:
    monkeypatch.setattr(runs, "QUIET_S", QUIET_S)
    over = run("over", age_s=0.0)
    (over / runs.VERDICT).write_bytes(content)
    said = clew("ls")
    assert (said.exit_code, "verdict.json cannot be read" in said.stdout) == (0, True)
    (told,) = json.loads(clew("ls", "--json").stdout)
    assert (told["verdict"], told["is_unreadable"], told["goes_on"]) == (None, True, False)
    assert clew("ls", over, "--delete", "--yes").exit_code == 0
    assert not over.exists()


@pytest.mark.parametrize(
    ("other", "why"),
    [
        ("runs", "is not the folder of a run"),
        ("runs/notes", "is not the"),
        ("nowhere", "there is no such run"),
    ],
)
@pytest.mark.parametrize("asked", [[], ["--json"], ["--delete", "--yes"]])
def test_what_is_no_run_is_neither_listed_nor_deleted(other: str, why: str, asked: list[str]) -> None:
    (Path("runs") / "notes").mkdir()
    said = clew("ls", run("one"), other, *asked)
    assert (said.exit_code, said.stdout) == (2, "")
    assert said.stderr.startswith(f"Error: {other}: {why}")
    assert sorted(Path("runs").iterdir()) == [Path("runs/notes"), Path("runs/one")]
