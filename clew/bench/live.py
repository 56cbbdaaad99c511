"""A live fleet that a benchmark watches while it runs: its timeline, its processes, its router. A shell."""

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path

import msgspec

from clew.bench.progress import Progress, Together
from clew.fleet.live import LAUNCHER, Ended, Launched
from clew.fleet.supervision.limits import limits_of
from protocol.errors import UsageError
from protocol.faults.manual_faults import WHERE_FILE
from protocol.files.toml_text import toml_text
from protocol.network.session import UNIX_SOCKET, unix_socket_endpoint
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.run_files import read_together, read_verdict
from world.scenario.fleets import SharedGround
from world.scenario.scenario import Scenario

SEED = 1
START_WALL_S, START_WALL_S_PER_ROBOT = 60.0, 0.5  # as the world waits, and some time to form
SOCKETS = Path("/proc/net/unix")
CONNECTED = "03"  # the state of a socket there


class LiveFleet:
    """A fleet of real processes. It must be ended."""

    def __init__(self, scenario: Scenario | SharedGround, folder: Path, *, speed: float) -> None:
        """Start it; the new folder gets the run, as `run`. Of several fleets each is a strand.

        Raises:
            UsageError: the folder exists, or cannot be made.
        """
        path, self.out = folder / "queue.toml", folder / "run"
        try:
            folder.mkdir(parents=True)
            path.write_text(toml_text(msgspec.to_builtins(scenario)), encoding="utf-8")
        except OSError as error:
            raise UsageError(f"cannot keep a run in {folder}: {error.strerror}") from error
        fleets = (
            {self.out / each.name: each.robots for each in scenario.fleets}
            if isinstance(scenario, SharedGround)
            else {self.out: scenario.fleet.robots}
        )
        self.folders = tuple(fleets)
        """The run's folder of each strand."""
        self.robots = sum(fleets.values())
        self._told = {folder: Progress(robots) for folder, robots in fleets.items()}
        self._read_bytes = dict.fromkeys(fleets, 0)
        self.progress = Together([*self._told.values()])
        self.began_s = time.time()
        """When its launcher was started [s since 1970]."""
        command = [*LAUNCHER, str(path), "--out", str(self.out), "--quiet"]
        promised = limits_of(self.robots, fleets=len(fleets), is_resumable=False)
        self._launched = Launched(
            [*command, "--speed", str(speed), "--seed", str(SEED)], end_s_max=2.0 * promised.all_s
        )

    @property
    def start_s_max(self) -> float:
        """How long it may take to form."""
        return START_WALL_S + START_WALL_S_PER_ROBOT * self.robots

    @property
    def processes(self) -> dict[int, str]:
        """The command lines of all its living processes, by process id."""
        return self._launched.processes

    @property
    def private(self) -> Path:
        """The folder of its sessions, while it runs."""
        return Path((self.out / WHERE_FILE).read_text(encoding="utf-8")).parent

    @property
    def sessions(self) -> int:
        """How many sessions its router has: connections at its socket, as the kernel counts them."""
        socket = unix_socket_endpoint(self.private).removeprefix(UNIX_SOCKET)
        rows = [line.split() for line in SOCKETS.read_text(encoding="utf-8").splitlines()]
        return sum(row[-1] == socket and row[5] == CONNECTED for row in rows)

    def has_ended(self, within_s: float) -> bool:
        """Whether it ends by itself within this time."""
        return self._launched.has_ended(within_s)

    def until(self, is_so: Callable[[], bool], wall_s_max: float) -> bool:
        """Whether that is so within this time, before the fleet ends."""
        until_s = time.monotonic() + wall_s_max
        while not is_so():
            if self._launched.has_ended() or time.monotonic() > until_s:
                return False
            self.look()
        return True

    def look(self) -> None:
        """Read what is new in its timelines."""
        for folder, progress in self._told.items():
            with contextlib.suppress(FileNotFoundError), (folder / "events.jsonl").open("rb") as file:
                file.seek(self._read_bytes[folder])
                piece = file.read()
                self._read_bytes[folder] += len(piece)
                progress.read(piece)

    def end(self) -> tuple[Ended, tuple[Verdict, ...]]:
        """End it if it still runs; returns how it ended, and the verdicts of its strands that have one."""
        ended = self._launched.end()
        judged = (folder for folder in self.folders if (folder / VERDICT_FILE).exists())
        return ended, tuple(read_verdict(folder) for folder in judged)

    @property
    def contacts(self) -> int:
        """How many pairs of robots of two strands have touched, when it has ended."""
        if len(self.folders) == 1 or not (self.out / VERDICT_FILE).exists():
            return 0
        return read_together(self.out).contact_count


def load() -> float:
    """The machine's load average of the last minute."""
    return os.getloadavg()[0]
