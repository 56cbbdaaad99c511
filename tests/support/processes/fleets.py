"""Starts real fleets for tests, and finds their processes by a mark in the environment: never another's."""

import json
import os
import shutil
import signal
import subprocess
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

T = TypeVar("T")

LAUNCHER = ROOT / "launch" / "fleet.sh"

NEVER = threading.Event()  # a process of another family announces nothing that could be waited for


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a launcher ended."""

    code: int
    out: str
    err: str


@dataclass(slots=True)
class Fleet:
    """One `launch/fleet.sh`, started in a folder of its own."""

    cwd: Path
    mark: str = field(default_factory=lambda: uuid4().hex)
    # Below /tmp and not below pytest's folder, whose path may be too long for a socket.
    temporary: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="ct.", dir="/tmp")))
    launcher: subprocess.Popen[str] | None = None

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return self.start_with(str(LAUNCHER), *arguments)

    def start_with(self, *command: str) -> subprocess.Popen[str]:
        """Start it by another command than the launcher, which brings the launcher in."""
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
        """Start it at a terminal, which becomes the one that its Ctrl-C comes from."""
        # A CI's own variables would have it print lines, as where nobody sits at the terminal.
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
        """The process that the launcher has started for a module: router, world or host."""
        assert self.launcher is not None
        children = Path(f"/proc/{self.launcher.pid}/task/{self.launcher.pid}/children").read_text().split()
        lines = self.processes()
        (pid,) = [int(child) for child in children if f"-m {module} " in lines.get(int(child), "")]
        return pid

    def folder(self) -> Path:
        """The folder of the one run started here."""
        return (self.cwd / "runs" / "latest").resolve()

    def entries(self) -> list[dict[str, Any]]:
        """What the timeline holds by now; a line that is being written is left out."""
        path = self.folder() / "events.jsonl"
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def wait_for(self, kind: str) -> dict[str, Any]:
        """The first entry of a kind, when it has come."""

        def first() -> dict[str, Any] | None:
            return next((entry for entry in self.entries() if entry["kind"] == kind), None)

        return wait_until(first)

    def verdict(self) -> dict[str, Any]:
        read: dict[str, Any] = json.loads((self.folder() / "verdict.json").read_text(encoding="utf-8"))
        return read

    def leftovers(self) -> list[str]:
        """Processes, sockets and folders that ought to be gone."""
        return [*self.processes().values(), *map(str, self.temporary.iterdir())]

    def destroy(self) -> None:
        """End whatever a failed test has left."""
        for pid in self.processes():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        if self.launcher is not None:
            self.launcher.communicate(timeout=DEADLINE_S)
        shutil.rmtree(self.temporary)


def wait_until(look: Callable[[], T | None], timeout_s: float = DEADLINE_S) -> T:
    """What `look` finds, as soon as it finds something."""
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
