"""A fleet whose parts are started one by one, each in a place that the test chooses."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from protocol.faults.plan import NO_FAULTS
from protocol.network.session import write_sessions
from protocol.root import ROOT
from protocol.run_settings import Settings
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import Fleet
from world.record.run_files import prepare_folder
from world.scenario.scenario import Scenario

Command = list[str]


def here(*command: str) -> Command:
    """A command line that runs a command in this namespace, as `netns.Namespace.command` does in another."""
    return list(command)


@dataclass(frozen=True, slots=True)
class Parts:
    """What to start and where."""

    fleet: Fleet
    robots: int
    scenario: Scenario
    settings: Settings
    endpoint: str
    """The endpoint that all clients connect to."""
    listen: str
    """The endpoint at which the router listens."""
    near: Callable[..., Command] = here
    """Wraps the command lines of router and world."""
    far: Callable[..., Command] = here
    """Wraps the command line of the robots."""

    @contextlib.contextmanager
    def started(self) -> Iterator[subprocess.Popen[str]]:
        """The world's process, while all parts run; they end with the context or with this process."""
        sessions = self.fleet.temporary / "sessions"
        write_sessions(sessions, fleet="f", run="packets", robots=self.robots, endpoints=[self.endpoint])
        with contextlib.ExitStack() as stack:
            router = ["-m", "protocol", "--sessions", str(sessions), "--listen", self.listen]
            stack.enter_context(self._part(self.near, *router, ready="ready "))
            run = self.fleet.folder()
            run.mkdir(parents=True, exist_ok=True)
            prepare_folder(run, self.scenario, NO_FAULTS, self.settings)
            world = [str(run), "--session", str(sessions / "world.json")]
            yielded = stack.enter_context(self._part(self.near, "-m", "world", *world))
            robots = ["--robots", f"1-{self.robots}", "--sessions", str(sessions)]
            stack.enter_context(self._part(self.far, "-m", "agents", *robots))
            yield yielded

    @contextlib.contextmanager
    def _part(
        self, where: Callable[..., Command], *arguments: str, ready: str = ""
    ) -> Iterator[subprocess.Popen[str]]:
        environment = {**os.environ, "CLEW_TEST_MARK": self.fleet.mark}
        pipe = subprocess.PIPE
        with (
            self.fleet.said.open("a") as said,
            subprocess.Popen(
                where(sys.executable, *arguments, "--lifeline"),
                cwd=ROOT,
                env=environment,
                stdin=pipe,
                stdout=pipe,
                stderr=said,
                text=True,
            ) as part,
        ):
            try:
                assert part.stdout is not None
                if ready:
                    assert part.stdout.readline().startswith(ready)
                yield part
            finally:
                _end(part)


def _end(part: subprocess.Popen[str]) -> None:
    assert part.stdin is not None
    part.stdin.close()
    try:
        part.wait(DEADLINE_S)
    finally:
        part.kill()


def said(fleet: Fleet) -> str:
    """Everything that the parts have printed on stderr."""
    return fleet.said.read_text(encoding="utf-8")
