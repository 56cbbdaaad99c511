"""Starts real fleets for tests, and finds exactly their processes by a mark in the environment."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.judges import differences

T = TypeVar("T")

LAUNCHER = ROOT / "launch" / "fleet.sh"

NEVER = threading.Event()  # a process that is not our child sends no event to wait for


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a launcher ended."""

    code: int
    out: str
    err: str


@dataclass(slots=True)
class Fleet:
    """One `launch/fleet.sh`, started in a new folder."""

    cwd: Path
    mark: str = field(default_factory=lambda: uuid4().hex)
    # Below /tmp: the path of pytest's folder may be too long for a socket.
    temporary: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="ct.", dir="/tmp")))
    launcher: subprocess.Popen[str] | None = None

    @property
    def said(self) -> Path:
        """The file for what parts print on stderr that have no launcher."""
        return self.cwd / "said"

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return self.start_with(str(LAUNCHER), *arguments)

    def start_with(self, *command: str) -> subprocess.Popen[str]:
        """Start it by another command, which calls the launcher."""
        marked = {"TMPDIR": str(self.temporary), "CLEW_TEST_MARK": self.mark}
        self.launcher = subprocess.Popen(
            command,
            cwd=self.cwd,
            env={**os.environ, "PYTHONPATH": str(ROOT), **marked},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        return self.launcher

    def start_on(self, terminal: int, *arguments: str, **variables: str) -> subprocess.Popen[str]:
        """Start it at a terminal, which becomes its controlling terminal: Ctrl-C there reaches it."""
        # With the variables of a CI it would print lines instead of a table.
        ours = {name: value for name, value in os.environ.items() if name not in ("CI", "NO_COLOR")}
        marked = {"TMPDIR": str(self.temporary), "CLEW_TEST_MARK": self.mark}
        self.launcher = subprocess.Popen(
            [LAUNCHER, *arguments],
            cwd=self.cwd,
            env={**ours, **marked, **variables},
            preexec_fn=lambda: os.login_tty(terminal),  # noqa: PLW1509 - no other way to give it the terminal
            text=True,
        )
        return self.launcher

    def end(self, timeout_s: float = DEADLINE_S) -> Outcome:
        assert self.launcher is not None
        out, err = self.launcher.communicate(timeout=timeout_s)
        if (self.cwd / "runs" / "latest").exists():
            assert differences(self.folder()) == [], "the second judge agrees"
        return Outcome(self.launcher.returncode, out, err)

    def run(self, *arguments: str, timeout_s: float = DEADLINE_S) -> Outcome:
        self.start(*arguments)
        return self.end(timeout_s)

    def processes(self) -> dict[int, str]:
        """The command lines of all living processes of this fleet, by process id."""
        found = {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    if self.mark.encode() in (entry / "environ").read_bytes():
                        found[int(entry.name)] = (
                            (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                        )
                except OSError:
                    continue  # it has just ended
        return found

    def process(self, module: str) -> int:
        """The process id of the part that runs this module: router, world or host."""
        assert self.launcher is not None
        children = Path(f"/proc/{self.launcher.pid}/task/{self.launcher.pid}/children").read_text().split()
        lines = self.processes()
        (pid,) = [int(child) for child in children if f"-m {module} " in lines.get(int(child), "")]
        return pid

    def folder(self) -> Path:
        """The folder of the only run started here."""
        return (self.cwd / "runs" / "latest").resolve()

    def entries(self) -> list[dict[str, Any]]:
        """The entries of the timeline so far, without a line that is still being written."""
        return list(map(json.loads, self._lines()))

    def _lines(self) -> list[bytes]:
        path = self.folder() / "events.jsonl"
        lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
        return lines[:-1] if lines and not lines[-1].endswith(b"\n") else lines

    def wait_for(self, kind: str) -> dict[str, Any]:
        """Wait for the first entry of a kind."""

        def first() -> dict[str, Any] | None:
            told = (json.loads(line) for line in self._lines() if kind.encode() in line)  # few are read whole
            return next((entry for entry in told if entry["kind"] == kind), None)

        return wait_until(first)

    def verdict(self) -> dict[str, Any]:
        read: dict[str, Any] = json.loads((self.folder() / "verdict.json").read_text(encoding="utf-8"))
        return read

    def leftovers(self) -> list[str]:
        """Processes, sockets and folders that should be gone."""
        return [*self.processes().values(), *map(str, self.temporary.iterdir())]

    def destroy(self) -> None:
        """End everything that a failed test has left.

        What was printed on stderr is printed again: pytest shows it if the test has failed.
        """
        for pid in self.processes():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        if self.launcher is not None:
            _, err = self.launcher.communicate(timeout=DEADLINE_S)
            sys.stderr.write(err or "")  # None at a terminal
        if self.said.exists():
            sys.stderr.write(self.said.read_text(encoding="utf-8"))
        shutil.rmtree(self.temporary)


def wait_until(look: Callable[[], T | None], timeout_s: float = DEADLINE_S) -> T:
    """Wait until `look` finds something; returns it."""
    deadline_s = time.monotonic() + timeout_s
    while (found := look()) is None:
        assert time.monotonic() < deadline_s, f"waited {timeout_s} s in vain"
        NEVER.wait(0.02)
    return found


def clew(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [ROOT / "launch" / "clew", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )
