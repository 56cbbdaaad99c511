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
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from protocol.process.asked import AskedToEnd, asked_to_end
from protocol.root import IS_CHECKOUT, ROOT

LAUNCHER = (sys.executable, "-m", "clew.cli", "run")
"""What `launch/fleet.sh` becomes. An installed package does not have that script."""

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

    @property
    def last_words(self) -> str:
        """The last line of its stderr."""
        return self.said[-1] if self.said else "it said nothing"


class Launched:
    """A launcher that was started, with all that it starts."""

    def __init__(
        self,
        command: Sequence[str | Path],
        environment: Mapping[str, str] = MappingProxyType({}),
        *,
        end_s_max: float = END_S_MAX,
    ) -> None:
        """Start it; `environment` adds to ours, and it is killed so long after it was told to end."""
        self._since_s, self._end_s_max = time.monotonic(), end_s_max
        self._ended: Ended | None = None
        with contextlib.ExitStack() as stack:
            self._stderr = stack.enter_context(tempfile.TemporaryFile())
            temporary = stack.enter_context(tempfile.TemporaryDirectory(prefix="clew-live."))
            self._temporary = Path(temporary)
            self._launcher = subprocess.Popen(  # noqa: S603 - our own launcher, without a shell
                command,
                env={**os.environ, **environment, "TMPDIR": temporary},
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._stderr,
                start_new_session=True,
            )
            self._files = stack.pop_all()

    @property
    def wall_s(self) -> float:
        """For how long it has run."""
        return time.monotonic() - self._since_s if self._ended is None else self._ended.wall_s

    @property
    def processes(self) -> dict[int, str]:
        """The command lines of all its living processes, by process id."""
        return processes_of(self._temporary)

    def has_ended(self, within_s: float = LOOK_S) -> bool:
        """Whether it ends by itself within this time."""
        return self._ended is not None or _has_ended(self._launcher, within_s)

    def end(self) -> Ended:
        """End it if it still runs; kills what it has left behind."""
        if self._ended is None:
            code = _end(self._launcher, self._end_s_max)
            wall_s = self.wall_s
            leftovers = left_behind(self._temporary)
            self._stderr.seek(0)
            said = tuple(self._stderr.read().decode(errors="replace").splitlines())
            self._ended = Ended(code=code, said=said, wall_s=wall_s, leftovers=leftovers)
            self._files.close()
        return self._ended


def run_fleet(
    arguments: Sequence[str], *, wall_s_max: float, until: Callable[[], bool] = lambda: False
) -> Ended:
    """Run a fleet until it ends. It is asked to end when the time is up or `until` returns True.

    Raises:
        AskedToEnd: we were asked to end; the fleet has ended.
    """
    with asked_to_end() as asked:
        launched = Launched([*LAUNCHER, *arguments], our_environment())
        try:
            while not (asked or launched.has_ended() or until() or launched.wall_s > wall_s_max):
                pass
        finally:
            ended = launched.end()
        if asked:
            raise AskedToEnd(asked[0])
        return ended


def our_environment() -> Mapping[str, str]:
    """Ours come first, whatever is in the folder that we are called in; as launch/setup.sh has it."""
    paths = [str(ROOT)] if IS_CHECKOUT else []
    paths += [path for path in [os.environ.get("PYTHONPATH")] if path]
    threads = {"OPENBLAS_NUM_THREADS": "1", "PYTHONSAFEPATH": "1"}
    return {**threads, **({"PYTHONPATH": os.pathsep.join(paths)} if paths else {})}


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


def _has_ended(launcher: subprocess.Popen[bytes], within_s: float) -> bool:
    try:
        launcher.wait(within_s)
    except subprocess.TimeoutExpired:
        return False
    return True


def _end(launcher: subprocess.Popen[bytes], within_s: float) -> int | None:
    """End the launcher if it still runs; returns its exit code, or None if it had to be killed."""
    launcher.terminate()
    if _has_ended(launcher, within_s):
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
