"""The processes of a fleet: starts them, signals them, and reports when they are ready, ended or gone.

Rule 1: each part has its own process group. So Ctrl-C reaches only the launcher, and robots can be found
        after their host has died.
Rule 2: the private folder holds the process ids, `world.pid` and so on, each written atomically. `router.pid`
        links to that of the active router.
Rule 3: a group is signalled only while it may have members: afterwards, another group may get its number.
Rule 4: robots whose host has died become our children (`orphans_adopted`), so that we see them end.
"""

import asyncio
import contextlib
import ctypes
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from clew.fleet.parts.command_lines import PARTS, Stdout, command_of
from clew.fleet.prepare import Prepared
from clew.fleet.supervision.events import ROUTER, Ended, Event, Gone, Ready

READ_BYTES_MAX = 4096
KILLED_S_MAX = 0.4  # for the kernel to end killed processes
STDERR = 2
PR_SET_CHILD_SUBREAPER = 36  # of Linux: prctl(2)

Process = subprocess.Popen[bytes]


class Processes:
    """All processes that we have started, by part."""

    def __init__(self, run: Prepared, lifeline: int, stderr: int, tell: Callable[[Event], None]) -> None:
        self._run, self._lifeline, self._stderr, self._tell = run, lifeline, stderr, tell
        self._loop = asyncio.get_running_loop()
        self._groups: dict[str, list[Process]] = {}
        """For each part, the first process of every group that may have members, the newest last."""

    def start(self, part: str, *, resume: bool) -> None:
        """Start a part.

        Raises:
            OSError: the system cannot start it.
        """
        stdout = PARTS[part].stdout
        stderr = STDERR if stdout is Stdout.TERMINAL else self._stderr
        with contextlib.ExitStack() as stack:
            if stdout is Stdout.READY:
                reading_end, writing_end = os.pipe()
                stack.callback(os.close, writing_end)
                self._loop.add_reader(reading_end, self._read, part, reading_end, bytearray())
            process = subprocess.Popen(  # noqa: S603 - our own programs, without a shell
                command_of(part, self._run, resume=resume),
                stdin=self._lifeline,
                stdout=writing_end if stdout is Stdout.READY else stderr,
                stderr=stderr,
                process_group=0,
            )
        self._groups.setdefault(part, []).append(process)
        _replace(self._path(part), lambda new: new.write_text(f"{process.pid}\n", encoding="ascii"))

    def signal(self, part: str, number: signal.Signals, *, group: bool) -> None:
        """Signal a part's newest process, or all of its groups."""
        processes = self._groups.get(part, [])
        if group:
            for process in processes:
                _signal_group(process, number)
        elif processes:
            processes[-1].send_signal(number)  # does nothing if it has ended

    def activate(self, router: str) -> None:
        """Record that this router carries the fleet."""
        _replace(self._path(ROUTER), lambda new: new.symlink_to(self._path(router).name))

    def look(self) -> None:
        """Report which processes have ended and which groups are empty, after a child of ours has ended."""
        for part, processes in list(self._groups.items()):
            for process in processes:
                if process.returncode is None and (status := process.poll()) is not None:
                    self._tell(Ended(part, status))
        for part, processes in list(self._groups.items()):
            self._groups[part] = [process for process in processes if _has_members(process)]
            if not self._groups[part]:
                del self._groups[part]
                self._tell(Gone(part))

    def kill(self) -> None:
        """Kill everything that is left of all parts."""
        for part, processes in self._groups.items():
            self.signal(part, signal.SIGKILL, group=True)
            for process in processes:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(KILLED_S_MAX)

    def _read(self, part: str, descriptor: int, begun: bytearray) -> None:
        """Read a part's stdout. The first line means that it is ready; the rest is ignored."""
        text = os.read(descriptor, READ_BYTES_MAX)
        if not text:
            self._loop.remove_reader(descriptor)
            os.close(descriptor)
        elif b"\n" not in begun:
            begun += text
            line, end, _ = begun.partition(b"\n")
            if end:
                self._tell(Ready(part, line.decode(errors="replace")))

    def _path(self, part: str) -> Path:
        return self._run.private / f"{part}.pid"


@contextlib.contextmanager
def orphans_adopted() -> Iterator[None]:
    """While the context lasts, descendants whose parent has died become our children."""
    prctl = ctypes.CDLL(None).prctl
    prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    try:
        yield
    finally:
        prctl(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


def _has_members(process: Process) -> bool:
    if process.returncode is None:
        return True
    with contextlib.suppress(ChildProcessError):  # none of its processes is our child
        while os.waitpid(-process.pid, os.WNOHANG) != (0, 0):
            pass
    try:
        os.killpg(process.pid, 0)
    except ProcessLookupError:
        return False
    return True


def _signal_group(process: Process, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError):  # it ended after the check
        os.killpg(process.pid, number)


def _replace(path: Path, write: Callable[[Path], object]) -> None:
    """Write this to a file atomically, replacing an older one."""
    new = path.with_suffix(".new")
    write(new)
    new.replace(path)
