"""`clew run` up to the start of a run, and its refusals."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from clew.fleet.parts.private import FALLBACK, PATH_BYTES_MAX, private_folder
from clew.verbs.run import Requests
from protocol.exit_codes import ExitCode
from protocol.root import ROOT
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import wait_until


@dataclass(frozen=True, slots=True)
class Folders:
    """The working folder of a launcher and its folder for temporary files."""

    cwd: Path
    temporary: Path

    def hold_nothing(self) -> bool:
        return [*self.cwd.iterdir(), *self.temporary.iterdir()] == []


@pytest.fixture(autouse=True)
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Folders]:
    monkeypatch.setattr("clew.verbs.run.listen", lambda _: None)  # keeps our own signal handlers
    monkeypatch.setattr("clew.verbs.run.ignore", lambda: None)
    monkeypatch.chdir(tmp_path)
    with TemporaryDirectory(prefix="ct.", dir="/tmp") as temporary:
        monkeypatch.setenv("TMPDIR", temporary)
        yield Folders(tmp_path, Path(temporary))


@pytest.mark.parametrize("before", [[], ["paper", "-n", "none"]])
def test_help_goes_to_stdout_and_names_every_option(
    before: list[str],
) -> None:
    said = clew("run", *before, "--help")
    assert (said.exit_code, said.stderr) == (0, "")
    for option in (
        "SCENARIO",
        "-n",
        "--seed",
        "--law",
        "--speed",
        "--out",
        "--json",
        "--view",
        "--quiet",
        "--connect",
        "--listen",
    ):
        assert option in said.stdout


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["atlantis"], "atlantis"),
        (["-n", "0"], "-n"),
        (["--out", "/proc/clew/run"], "cannot write a run into /proc/clew/run"),
        (["paper", "--speed", "fast"], "--speed"),
        (["--out", "new/" + "x" * 300], "File name too long"),  # after `new` was made
        (
            ["--faults", "one-way", "-n", "3"],
            "Error: one-way: $.rule[0].group[1]: must be a robot of the fleet, r1 to r3, got r4",
        ),
        (["--listen", "nonsense"], "nonsense"),
        (["--listen", "unixsock-stream//tmp/" + "x" * 120], "107 bytes"),
    ],
)
def test_refusal_is_one_line_and_leaves_nothing(
    arguments: list[str],
    complaint: str,
    folders: Folders,
) -> None:
    said = clew("run", *arguments)
    assert (said.exit_code, said.stdout) == (2, "")
    assert said.stderr.startswith("Error: ")
    assert said.stderr.count("\n") == 1
    assert complaint in said.stderr
    assert folders.hold_nothing()


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("range_m_max =", "range_m_maxx =", "range_m_maxx"),
        ("at_m = [", "at_m = [-999.0, -999.0] # [", "goal"),
        ("spacing_m =", "spacing_m = 0.0001 #", "spacing_m"),
        ("robots = 5", "robots = 0", "robots"),
        ("robots = 5", "robots = = 5", "line"),
    ],
)
def test_impossible_scenario_is_refused_in_one_line_with_exit_2(
    old: str, new: str, complaint: str, folders: Folders
) -> None:
    text = (ROOT / "launch" / "scenarios" / "grove.toml").read_text(encoding="utf-8")
    assert old in text
    mine = folders.cwd / "mine.toml"
    mine.write_text(text.replace(old, new, 1), encoding="utf-8")
    ended = clew("run", "mine.toml")
    said = ended.stderr
    assert ended.exit_code == 2
    assert said.count("\n") == 1, said
    assert "mine.toml" in said
    assert complaint in said
    mine.unlink()
    assert folders.hold_nothing()


def test_missing_folder_for_temporary_files_is_refused_in_one_line_with_exit_2(
    folders: Folders, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(folders.temporary / "nowhere"))
    ended = clew("run")
    assert ended.exit_code == 2
    assert "no folder for the run's sockets can be made in" in ended.stderr


def test_only_the_user_can_enter_the_private_folder_and_it_ends_with_its_context(folders: Folders) -> None:
    with private_folder(str(folders.temporary)) as private:
        assert private.folder.stat().st_mode & 0o777 == 0o700
        (private.folder / "world.pid").write_text("{part.pid}\\n")
    assert folders.hold_nothing()


def test_temporary_folder_with_a_path_too_long_for_sockets_is_not_used(tmp_path: Path) -> None:
    deep = tmp_path / ("x" * PATH_BYTES_MAX)
    deep.mkdir()
    with private_folder(str(deep)) as private:
        assert private.folder.parent == FALLBACK


def test_private_folder_and_a_frozen_part_end_when_we_are_killed(folders: Folders) -> None:
    """Another process takes our part here: it freezes a part of its own and kills itself."""
    script = f"""
import os, signal, subprocess, sys
from clew.verbs.run import Requests
from clew.fleet.parts.private import private_folder
with private_folder({str(folders.temporary)!r}) as private:
    part = subprocess.Popen(["cat"], stdin=private.lifeline, stdout=sys.stdout, process_group=0)
    (private.folder / "world.pid").write_text(f"{{part.pid}}\\n")
    part.send_signal(signal.SIGSTOP)
    os.kill(os.getpid(), signal.SIGKILL)
"""
    command = [sys.executable, "-c", script]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    ended = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, timeout=DEADLINE_S, check=False
    )  # also waits for the part, which holds our pipe
    assert ended.returncode == -signal.SIGKILL
    wait_until(lambda: folders.hold_nothing() or None)


def test_requests_are_kept_until_there_is_a_listener() -> None:
    requests, told = Requests(), list[ExitCode]()
    requests.note(ExitCode.INTERRUPTED)
    requests.hear(told.append)
    requests.note(ExitCode.TERMINATED)
    assert told == [ExitCode.INTERRUPTED, ExitCode.TERMINATED]
