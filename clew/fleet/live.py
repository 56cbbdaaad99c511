"""Runs a live fleet, real processes and all, and says what it has left behind. A shell.

Rule 1: each fleet has a folder of its own for temporary files. All its processes bear its name in their
        environment, whoever their parent is by now, so whoever bears it when the launcher has ended was left.
Rule 2: what was left is ended here: the next fleet is not to suffer from it.
Rule 3: a fleet has a session of its own: who asks us to end asks us alone, and we end it first, undisturbed.
        If we are killed nobody does, and it goes on to its own end.
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

END_S_MAX = 10.0  # from SIGTERM to the launcher's end: twice what it promises
GONE_S_MAX = 1.0  # for processes that have been killed to be gone, on a machine that is busy
LOOK_S = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a fleet came to its end."""

    code: int | None
    """The launcher's exit code; None: it had to be killed."""
    said: tuple[str, ...]
    """The lines of its stderr."""
    wall_s: float
    leftovers: tuple[str, ...]
    """Command lines of processes, and names of files."""


def run_fleet(
    arguments: Sequence[str], *, wall_s_max: float, until: Callable[[], bool] = lambda: False
) -> Ended:
    """Run a fleet until it ends; it is told to when the time is up, or `until` says so.

    Raises:
        AskedToEnd: we were, and the fleet has gone.
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
    """The command lines of all living processes that bear this folder in their environment, by process id."""
    mark, found = f"TMPDIR={temporary}".encode(), {}
    for entry in Path("/proc").iterdir():
        # It may have just ended, or be another user's.
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
    """Have the launcher end, unless it has; its exit code if it did so by itself or when asked."""
    launcher.terminate()
    if _has_ended(launcher, END_S_MAX):
        return launcher.returncode
    launcher.kill()
    launcher.wait()
    return None


def left_behind(temporary: Path) -> tuple[str, ...]:
    """What is there of a fleet that has ended; afterwards nothing is."""
    deadline_s = time.monotonic() + GONE_S_MAX
    while (left := processes_of(temporary)) and time.monotonic() < deadline_s:
        time.sleep(LOOK_S)
    for pid in left:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return (*left.values(), *(path.name for path in sorted(temporary.iterdir())))
