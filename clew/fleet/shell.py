"""The shell of a supervisor: clock, signals and files. It decides nothing.

Rule 1: on every exit, even after an error of our own, the rest of the fleet is killed.
Rule 2: events are handled one at a time: an event caused by a command waits until all commands are done.
"""

import asyncio
import contextlib
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, assert_never

from clew.fleet.folder import drop_folder, make_latest
from clew.fleet.output import STDERR, Output, output, say_result, say_start
from clew.fleet.parts.private import private_folder
from clew.fleet.parts.processes import READ_BYTES_MAX, Processes, orphans_adopted
from clew.fleet.prepare import Prepared, Shows, prepare
from clew.fleet.request import Request
from clew.fleet.runs import verdict_in
from clew.fleet.stand_in import stand_in
from clew.fleet.supervision.events import (
    Activate,
    Asked,
    Begun,
    Command,
    Ended,
    Event,
    Exit,
    Gone,
    Judged,
    MendTerminal,
    Publish,
    Say,
    Signal,
    Start,
    Tick,
    fault_in,
)
from clew.fleet.supervision.facts import name_of
from clew.fleet.supervision.limits import Plan, limits_of
from clew.fleet.supervisor import Supervisor
from protocol.exit_codes import ExitCode
from protocol.faults.manual_faults import WHERE_FILE
from protocol.faults.process_commands import PIPE

Hear = Callable[[Callable[[ExitCode], None]], None]


def run_fleet(request: Request, hear: Hear) -> int:
    """Run a fleet as requested; returns the exit code.

    Args:
        request: the user's request.
        hear: takes the function to call for each request to end, earlier ones included.

    Raises:
        UsageError: the request cannot work.
        SessionLostError: the user's router was lost during the check.
    """
    terminal = sys.stderr.isatty() and sys.stdout.isatty()  # no table in `fleet.sh | tee`
    with private_folder(os.environ.get("TMPDIR")) as private:
        run = prepare(request, private.folder, terminal=terminal)
        say_start(run)
        with orphans_adopted(), output(run) as words:
            code = asyncio.run(supervise(run, private.lifeline, words, hear))
        return finish(run, code)


def finish(run: Prepared, code: int) -> int:
    """Print the result of a run, or remove what a run that never began has made; returns the exit code."""
    try:
        if not say_result(run, stand_in(run, code)):
            drop_folder(run.folder, run.made, run.latest)
    except OSError as error:
        Output(STDERR).say(f"the result could not be written: {error.strerror}")
        return code or ExitCode.FAILED
    return code


async def supervise(run: Prepared, lifeline: int, output: Output, hear: Hear) -> int:
    """Start a prepared run and supervise it to its end, as in `run_fleet`."""
    loop = asyncio.get_running_loop()
    shell = _Shell(run, lifeline, output)
    loop.set_exception_handler(shell.fail)
    loop.add_signal_handler(signal.SIGCHLD, shell.processes.look)
    try:
        with _faults_asked(run.private / PIPE, shell.tell):
            hear(lambda code: shell.tell_soon(Asked(code)))
            shell.tell_soon(Begun())
            return await shell.code
    finally:
        shell.processes.kill()
        for fleet in run.fleets or ("",):  # a world that was killed has left it
            (run.folder / fleet / WHERE_FILE).unlink(missing_ok=True)


class _Shell:
    """Feeds events to a supervisor and executes its commands."""

    def __init__(self, run: Prepared, lifeline: int, output: Output) -> None:
        self._loop = asyncio.get_running_loop()
        self.code: asyncio.Future[int] = self._loop.create_future()
        """The exit code, after there is nothing left to supervise."""
        self.processes = Processes(run, lifeline, output.stderr, self.tell)
        self._run, self._output = run, output
        plan = Plan(routers=run.own_routers, view=run.view, table=run.shows is Shows.TABLE)
        # A world of several fleets is not started again: their clocks would go on from different times.
        limits = limits_of(run.robots, fleets=len(run.fleets), is_resumable=not run.fleets)
        self._supervisor = Supervisor(plan, limits)
        self._judged = False
        self._events: deque[Event] = deque()
        self._is_telling = False
        self._timer: asyncio.TimerHandle | None = None

    def tell_soon(self, event: Event) -> None:
        """Pass on an event from any context, for example from a signal handler."""
        self._loop.call_soon_threadsafe(self.tell, event)

    def fail(self, _: asyncio.AbstractEventLoop, context: Mapping[str, Any]) -> None:
        """A callback of the loop has raised: an error of our own."""
        if not self.code.done():
            self.code.set_exception(context.get("exception") or RuntimeError(context["message"]))

    def tell(self, event: Event) -> None:
        """Handle an event."""
        self._events.append(event)
        if self._is_telling:
            return
        self._is_telling = True
        while self._events:
            self._look_for_verdict()
            for command in self._supervisor.handle(self._events.popleft(), self._loop.time()):
                self._obey(command)
        self._is_telling = False
        self._set_timer()

    def _look_for_verdict(self) -> None:
        if not self._judged and (judged := verdict_in(self._run.folder, Judged)) is not None:
            self._judged = True
            self._events.appendleft(judged)

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        at_s = self._supervisor.wake_at()
        self._timer = None if at_s is None else self._loop.call_at(at_s, self.tell, Tick())

    def _obey(self, command: Command) -> None:
        match command:
            case Start(part, resume):
                self._start(part, resume=resume)
            case Signal(part, number, group):
                self.processes.signal(part, number, group=group)
            case Say(text):
                self._output.say(text)
            case Activate(part):
                self._activate(part)
            case MendTerminal():
                self._output.mend_terminal()
            case Publish():
                self._publish()
            case Exit(code) if not self.code.done():
                self.code.set_result(code)
            case Exit():
                pass
            case _:
                assert_never(command)

    def _start(self, part: str, *, resume: bool) -> None:
        try:
            self.processes.start(part, resume=resume)
        except OSError as error:
            self._output.say(f"{name_of(part)} cannot be started: {error.strerror}")
            self.tell(Ended(part, ExitCode.FAILED))
            self.tell(Gone(part))

    def _activate(self, part: str) -> None:
        try:
            self.processes.activate(part)
        except OSError as error:  # only who looks the process up misses it
            self._output.say(f"nobody is told that {name_of(part)} carries the fleet: {error.strerror}")

    def _publish(self) -> None:
        if self._run.latest is not None:
            with contextlib.suppress(OSError):  # the link is a convenience: a run works without it
                make_latest(self._run.folder)


@contextlib.contextmanager
def _faults_asked(path: Path, tell: Callable[[Event], None]) -> Iterator[None]:
    """Receive process faults through a pipe, one per line, while the context lasts."""
    os.mkfifo(path, 0o600)
    descriptor = os.open(
        path, os.O_RDWR | os.O_NONBLOCK
    )  # with our own writing end open, it never reaches its end of file
    begun = bytearray()

    def read() -> None:
        begun.extend(os.read(descriptor, READ_BYTES_MAX))
        *lines, rest = begun.split(b"\n")
        begun[:] = rest[-READ_BYTES_MAX:]
        for line in lines:
            if (fault := fault_in(line.decode(errors="replace"))) is not None:
                tell(fault)

    loop = asyncio.get_running_loop()
    loop.add_reader(descriptor, read)
    try:
        yield
    finally:
        loop.remove_reader(descriptor)
        os.close(descriptor)
