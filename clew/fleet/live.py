"""Runs a live fleet of real processes and reports what it has left behind. A shell.

Rule 1: each fleet has its own folder for temporary files. All its processes have the folder's name in their
        environment, even if their parent has died. A process that has it after the launcher's end is a
        leftover.
Rule 2: leftovers are killed here, so that they do not disturb the next fleet.
Rule 3: each fleet has its own session, so signals from the terminal reach only us. We stop the fleet before
        we exit. If we are killed, the fleet runs to its normal end.
"""

import contextlib
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from protocol.asked import AskedToEnd, asked_to_end
from protocol.root import ROOT

LAUNCHER = ROOT / "launch" / "fleet.sh"

END_S_MAX = 10.0  # from SIGTERM to the launcher's end: twice the time that it promises
GONE_S_MAX = 1.0  # until killed processes are gone, on a busy machine
LOOK_S = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a fleet ended."""

    code: int | None
    """The launcher's exit code; None: it had to be killed."""
    said: tuple[str, ...]
    """The lines of its stderr."""
    wall_s: float
    leftovers: tuple[str, ...]
    """Command lines of processes and names of files."""


def run_fleet(
    arguments: Sequence[str], *, wall_s_max: float, until: Callable[[], bool] = lambda: False
) -> Ended:
    """Run a fleet until it ends. It is asked to end when the time is up or `until` returns True.

    Raises:
        AskedToEnd: we were asked to end; the fleet has ended.
    """
    since_s = time.monotonic()
    with (
        asked_to_end() as asked,
        tempfile.TemporaryFile() as stderr,
        tempfile.TemporaryDirectory(prefix="clew-live.") as temporary,
    ):
        launcher = subprocess.Popen(  # noqa: S603 - our own launcher, without a shell
            [LAUNCHER, *arguments],
            env={**os.environ, "TMPDIR": temporary},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            start_new_session=True,
        )
        try:
            while not (asked or _has_ended(launcher) or until() or time.monotonic() - since_s > wall_s_max):
                pass
        finally:
            code = _end(launcher)
            wall_s = time.monotonic() - since_s
            leftovers = left_behind(Path(temporary))
        if asked:
            raise AskedToEnd(asked[0])
        stderr.seek(0)
        said = tuple(stderr.read().decode(errors="replace").splitlines())
        return Ended(code=code, said=said, wall_s=wall_s, leftovers=leftovers)


def processes_of(temporary: Path) -> dict[int, str]:
    """The command lines of all living processes with this folder in their environment, by process id."""
    mark, found = f"TMPDIR={temporary}".encode(), {}
    for entry in Path("/proc").iterdir():
        # It may have just ended or belong to another user.
        with contextlib.suppress(OSError):
            if entry.name.isdigit() and mark in (entry / "environ").read_bytes().split(b"\0"):
                found[int(entry.name)] = (
                    (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
                )
    return found


def _has_ended(launcher: subprocess.Popen[bytes], within_s: float = LOOK_S) -> bool:
    try:
        launcher.wait(within_s)
    except subprocess.TimeoutExpired:
        return False
    return True


def _end(launcher: subprocess.Popen[bytes]) -> int | None:
    """End the launcher if it still runs; returns its exit code, or None if it had to be killed."""
    launcher.terminate()
    if _has_ended(launcher, END_S_MAX):
        return launcher.returncode
    launcher.kill()
    launcher.wait()
    return None


def left_behind(temporary: Path) -> tuple[str, ...]:
    """The leftovers of a fleet that has ended; kills its processes."""
    deadline_s = time.monotonic() + GONE_S_MAX
    while (left := processes_of(temporary)) and time.monotonic() < deadline_s:
        time.sleep(LOOK_S)
    for pid in left:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return (*left.values(), *(path.name for path in sorted(temporary.iterdir())))
