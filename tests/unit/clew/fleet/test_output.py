"""The output of a fleet besides its verdict."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from clew.fleet.output import BEGIN_LINE, SHOW_CURSOR, output, say_result, say_start
from clew.fleet.prepare import Prepared, Shows
from clew.fleet.stand_in import stand_in
from protocol.exit_codes import ExitCode
from protocol.root import ROOT
from protocol.run_settings import Settings
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, PAPER, numbered, recorded
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.run_files import BEGUN_FILE, read_verdict

SAID = (
    b"router: ready\nworld: t=   0.4 s  strand formed\nworld: east: t=   0.4 s  strand formed\n"
    b"world: ok: all have arrived\nworld: east: FAILED: no route\nrobot 3: lost\n"
)
CURSOR, LINE = SHOW_CURSOR.decode(), BEGIN_LINE.decode()


def prepared(
    folder: Path, shows: Shows = Shows.LINES, *, as_json: bool = False, private: Path | None = None
) -> Prepared:
    return Prepared(
        private=private or folder,
        folder=folder,
        made=(),
        latest=None,
        scenario=PAPER,
        settings=Settings(seed=1),
        started_at="2026-11-20T00:00:00+00:00",
        own_routers=1,
        as_json=as_json,
        view=False,
        shows=shows,
    )


def test_lines_go_to_stderr_immediately(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with output(prepared(tmp_path)) as words:
        os.write(words.stderr, SAID)
        words.say("the page is here")
        assert capfd.readouterr().err == SAID.decode() + "clew: the page is here\n"
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("shows", "first"), [(Shows.NOTHING, ""), (Shows.TABLE, CURSOR)])
def test_with_a_table_or_quiet_messages_are_printed_at_the_end_without_progress(
    shows: Shows, first: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with output(prepared(tmp_path, shows)) as words:
        os.write(words.stderr, SAID)
        words.say("router 1 ended")
        assert capfd.readouterr() == ("", "")
    assert capfd.readouterr() == ("", f"{first}router: ready\nrobot 3: lost\nclew: router 1 ended\n")


def test_escape_sequences_in_kept_messages_do_not_reach_the_terminal(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with output(prepared(tmp_path, Shows.NOTHING)) as words:
        os.write(words.stderr, b"router: \x1b[2J\xff\n")
        words.say("no run in \x1b]0;here")
    assert capfd.readouterr().err == "router: \\x1b[2J\ufffd\nclew: no run in \\x1b]0;here\n"


def test_after_a_table_died_cursor_and_line_are_restored(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with output(prepared(tmp_path, Shows.TABLE)) as words:
        words.mend_terminal()
        assert capfd.readouterr().err == CURSOR + LINE


def test_closed_terminal_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*_: object) -> int:
        raise OSError

    with output(prepared(tmp_path, Shows.TABLE)) as words:
        monkeypatch.setattr(os, "write", gone)
        words.say("who hears?")
        words.mend_terminal()
    monkeypatch.undo()


def judged(folder: Path) -> Path:
    run = recorded(folder / "run", numbered(AT_REST))
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(GOOD))
    return run


def test_result_is_the_verdict_as_a_sentence_or_as_json(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    run = judged(tmp_path)
    assert say_result(prepared(run))
    assert capfd.readouterr().out.splitlines()[-1].endswith(f"Run: {run}")
    assert say_result(prepared(run, as_json=True))
    assert capfd.readouterr().out == (run / VERDICT_FILE).read_text(encoding="utf-8")


def test_run_without_a_verdict_names_its_log(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run = judged(tmp_path)
    (run / VERDICT_FILE).write_bytes(b"")
    killed = prepared(run)
    assert say_result(killed, stand_in(killed, ExitCode.FAILED))
    said = f"clew: FAILED: the run ended without a verdict of its world. Run: {run}\n"
    assert capfd.readouterr() == ("", said)
    verdict = read_verdict(run)
    assert (verdict.ok, verdict.exit_code, verdict.robots) == (False, 1, 5)


def test_verdict_of_a_world_is_never_replaced(tmp_path: Path) -> None:
    run = judged(tmp_path)
    assert stand_in(prepared(run), ExitCode.FAILED) is None
    assert read_verdict(run).ok


def test_stand_in_keeps_the_exit_code_and_is_printed_as_json(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    killed = prepared(recorded(tmp_path / "run", numbered(AT_REST)), as_json=True)
    assert say_result(killed, stand_in(killed, ExitCode.TERMINATED))
    printed = msgspec.json.decode(capfd.readouterr().out, type=Verdict)
    assert (printed.ok, printed.exit_code, printed) == (False, 143, read_verdict(killed.folder))


def test_run_whose_folder_was_removed_still_has_a_printed_verdict(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    gone = prepared(tmp_path / "gone", private=tmp_path, as_json=True)
    (tmp_path / BEGUN_FILE).touch()
    assert say_result(gone, stand_in(gone, ExitCode.FAILED))
    out, err = capfd.readouterr()
    assert msgspec.json.decode(out, type=Verdict).reason == "the run's folder was removed"
    assert err == f"clew: FAILED: the run's folder was removed. Run: {gone.folder}\n"
    assert not gone.folder.exists()


def test_run_that_never_began_has_no_result(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert not say_result(prepared(tmp_path))
    assert capfd.readouterr() == ("", "")


def test_pipe_closed_before_the_result_is_no_failure(tmp_path: Path) -> None:
    script = f"""
from pathlib import Path
from clew.fleet.output import say_result
from tests.unit.clew.fleet.test_output import prepared
assert say_result(prepared(Path({str(judged(tmp_path))!r})))
"""
    reading_end, writing_end = os.pipe()
    os.close(reading_end)
    try:
        ended = subprocess.run(
            [sys.executable, "-c", script],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=writing_end,
            stderr=subprocess.PIPE,
            timeout=DEADLINE_S,
            check=False,
        )
    finally:
        os.close(writing_end)
    assert (ended.returncode, ended.stderr) == (0, b"")


def test_a_result_that_cannot_be_written_fails_a_run_that_was_well(tmp_path: Path) -> None:
    script = f"""
import sys
from pathlib import Path
from clew.fleet.shell import finish
from tests.unit.clew.fleet.test_output import prepared
sys.exit(finish(prepared(Path({str(judged(tmp_path))!r})), int(sys.argv[1])))
"""
    for code, expected in ((0, 1), (143, 143)):
        with Path("/dev/full").open("wb") as full:
            ended = subprocess.run(
                [sys.executable, "-c", script, str(code)],
                cwd=ROOT,
                env={**os.environ, "PYTHONPATH": str(ROOT)},
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                timeout=DEADLINE_S,
                check=False,
            )
        said = "clew: the result could not be written: No space left on device\n"
        assert (ended.returncode, ended.stderr) == (expected, said)


@pytest.mark.parametrize(
    ("shows", "said"),
    [
        (Shows.NOTHING, ""),
        (Shows.TABLE, "clew: starting 5 robots\n"),
        (Shows.LINES, "clew: starting 5 robots\n"),
    ],
)
def test_before_the_first_entry_it_says_how_many_robots_start(
    shows: Shows, said: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    say_start(prepared(tmp_path, shows))
    assert capfd.readouterr() == ("", said)
