"""A host of robots: forks one process for each and reaps them. It opens no session, so forking is safe.

Rule 1: a robot that dies is reaped and reported; the others continue. If one of its fleet ends well after
        it, the host does so, too: then the run is over, and the verdict says who died.
Rule 2: when asked to end, the host asks all its robots, waits, and kills those that are left. It thaws frozen
        ones, so that they can react. Robots that end then are not failures.
Rule 3: a robot ends soon after its host: it holds the reading end of a pipe whose writing end only the host
        has.
Rule 4: a process fault that the world commands (`protocol.faults.process_commands`) is no failure of the
        robot, nor of the host. Without robots a host waits for one that was killed so: it may be told to
        start it again, unless another robot of that fleet has ended well. None does before the run is over.
Rule 5: robots are started as `starting.py` says; each tells its host through a pipe that it is connected.
"""

import asyncio
import contextlib
import gc
import os
import signal
import socket
import struct
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.process.shell import run
from agents.process.starting import Starting
from agents.process.warm import warm_up
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.process_commands import HostCommand, command_socket, received_commands
from protocol.faults.process_faults import ProcessAction
from protocol.keys import robot_name
from protocol.network.faulty_transport import Conditions
from protocol.network.inbox import OneTaskLoop
from protocol.network.session import read_session
from protocol.plain import plain
from protocol.process.allocation import fill_holes, forget_lookups, return_large_blocks
from protocol.process.asked import EXIT_CODES, signal_of
from protocol.process.ending import asked_to_end, until_ended

KILL_AFTER_S = 2.0  # wall: a fleet has 5 s to end, and its launcher needs some of that
PID = struct.Struct("=i")
PIDS_BYTES_MAX = 64 * PID.size  # in one look; written whole, so whole ones are read
HANDLED = (signal.SIGCHLD, *EXIT_CODES)  # signals that a host handles; robots reset them


@dataclass(frozen=True, slots=True, eq=False)
class Orders:
    """The settings for all robots of a fleet."""

    sessions: Path
    """Folder of the fleet's session files."""
    conditions: Conditions
    fleet: str = ""
    """The fleet's name, where the host has several."""

    def name_of(self, robot: int) -> str:
        """What users call a robot."""
        return f"robot {robot} of {self.fleet}" if self.fleet else f"robot {robot}"


Crew = tuple[Sequence[int], Orders]
"""The robots of a fleet that a host has."""
Place = tuple[Orders, int]
"""One of its robots."""


def run_robot(
    robot: int,
    told: Orders,
    lifeline: int | None,
    *,
    again: bool = False,
    on_connected: Callable[[], None] = lambda: None,
) -> int:
    """Run one robot in this process; returns the exit code.

    Args:
        robot: its number.
        told: the settings for all robots.
        lifeline: a file descriptor; the robot ends when the other end is closed.
        again: whether it is the successor of a process that has died.
        on_connected: called when it has a session.
    """
    try:
        session = read_session(told.sessions / f"{robot_name(robot)}.json")
        life = run(
            robot,
            session,
            conditions=told.conditions,
            sessions=told.sessions,
            again=again,
            on_connected=on_connected,
        )
        with asyncio.Runner(loop_factory=OneTaskLoop) as runner:
            return runner.run(until_ended(life, lifeline))
    except UsageError as error:
        say(f"{told.name_of(robot)}: {error}")
        return ExitCode.USAGE
    except SessionLostError as error:
        say(f"{told.name_of(robot)}: {error}")
        return ExitCode.FAILED


def run_host(crews: Sequence[Crew], lifeline: int | None) -> int:
    """Fork the robots and reap them; returns 0, or the first bad exit code of a failed fleet (rule 1)."""
    lifeline_ends, connected_ends = os.pipe(), os.pipe()
    return_large_blocks()
    warm_up()
    gc.collect()
    forget_lookups()
    fill_holes()
    gc.freeze()  # keeps loaded pages shared: the collector would touch, and so copy, them all
    with contextlib.ExitStack() as stack:
        for end in (*lifeline_ends, *connected_ends):
            stack.callback(os.close, end)
        host = _Host(lifeline_ends, connected_ends)
        for robots, told in crews:
            for robot in robots:
                host.start((told, robot))
        listening: list[tuple[socket.socket, Orders]] = []
        try:
            for robots, told in crews:
                listening.append((stack.enter_context(command_socket(told.sessions, min(robots))), told))
        except OSError as error:  # continue: only process faults are impossible, which few runs need
            say(f"host: cannot receive process faults: {error.strerror}")
        return asyncio.run(host.reap(lifeline, listening))


class _Host:
    """The running robots, and how the others ended."""

    def __init__(self, lifeline_ends: tuple[int, int], connected_ends: tuple[int, int]) -> None:
        """Each robot holds the reading end of one pipe, and tells by the other that it is connected."""
        self._lifeline, self._lifeline_end = lifeline_ends
        self._connected, self._connected_end = connected_ends
        self._robots: dict[int, Place] = {}
        """The robots by process id."""
        self._starting = Starting[Place]()
        self._killed: set[int] = set()
        """The processes that were killed by a fault."""
        self._failed: dict[Orders, int] = {}
        """The first bad exit code of each fleet that has one."""
        self._all_ended = asyncio.Event()
        self._down: set[Place] = set()
        """Robots that a fault has killed, and that were not started since (rule 4)."""
        self._over: set[Orders] = set()
        """The fleets of which a robot has ended well."""
        self._listening: Sequence[tuple[socket.socket, Orders]] = ()
        self._ends = False
        self._known: set[Place] = set()

    def start(self, place: Place) -> None:
        """Have a robot started, for the first time or again."""
        self._starting.wait(place)

    def _fork(self) -> None:
        while (place := self._starting.next()) is not None:
            self._down.discard(place)
            again = place in self._known
            self._known.add(place)
            pid = os.fork()
            if pid == 0:
                self._become(place, again=again)
            self._robots[pid] = place
            self._starting.began(pid)

    async def reap(self, lifeline: int | None, listening: Sequence[tuple[socket.socket, Orders]]) -> int:
        """Wait until all robots have ended. If asked to end, ask the robots to end."""
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGCHLD, self._reap)
        self._listening = listening
        for commands, _ in listening:
            loop.add_reader(commands, self._hear)
        loop.add_reader(self._connected, self._see_connected)
        self._fork()
        with asked_to_end(lifeline) as asked:
            ended = asyncio.ensure_future(self._all_ended.wait())
            either: list[asyncio.Future[Any]] = [ended, asked]
            await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            if ended.done():
                failed = (code for told, code in self._failed.items() if told not in self._over)
                return next(failed, ExitCode.OK)
            self._ends = True
            self._starting.end()
            self._signal_all(signal.SIGTERM)
            self._signal_all(signal.SIGCONT)
            self._note_end()
            await asyncio.wait([ended], timeout=KILL_AFTER_S)
            self._signal_all(signal.SIGKILL)
            await ended
            return asked.result()

    def _see_connected(self) -> None:
        self._starting.arrived(pid for (pid,) in PID.iter_unpack(os.read(self._connected, PIDS_BYTES_MAX)))
        self._fork()

    def _hear(self) -> None:
        for commands, told in self._listening:
            for command in received_commands(commands):
                if not self._ends:
                    self._execute(command, (told, command.robot))

    def _execute(self, command: HostCommand, place: Place) -> None:
        pids = [pid for pid, found in self._robots.items() if found == place]
        match command.action:
            case ProcessAction.KILL:
                self._killed.update(pids)
                if self._starting.forget(place):  # the last command counts
                    self._down.add(place)
                number = signal.SIGKILL
            case ProcessAction.FREEZE:
                self._starting.hold(place)
                number = signal.SIGSTOP
            case ProcessAction.THAW:
                self._starting.let_go(place)
                self._fork()
                number = signal.SIGCONT
            case ProcessAction.START:
                self._start_again(place, pids)
                return
            case ProcessAction.SLOW | ProcessAction.UNSLOW:
                return  # robots receive that themselves
        for pid in pids if not command.done else ():
            os.kill(pid, number)  # the process exists: it has not been reaped

    def _start_again(self, place: Place, pids: Sequence[int]) -> None:
        if self._killed.intersection(pids):
            self._starting.wait(place, after=pids)
        elif not pids and (place in self._known or place in self._down):
            self.start(place)
            self._fork()

    def _reap(self) -> None:
        self._hear()  # a robot that kills itself by a fault has reported it before
        while self._robots:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            self._starting.ended(pid)
            place, exit_code = self._robots.pop(pid), os.waitstatus_to_exitcode(status)
            killed = pid in self._killed and exit_code == -signal.SIGKILL
            if killed:
                self._down.add(place)
            if exit_code == 0:
                self._over.add(place[0])
            # Until it handles signals, SIGTERM ends it at once.
            as_asked = self._ends and exit_code in {ExitCode.TERMINATED, -signal.SIGTERM}
            if exit_code != 0 and not (killed or as_asked):
                told, robot = place
                self._failed.setdefault(told, max(exit_code, ExitCode.FAILED))  # a signal's is negative
                say(f"{told.name_of(robot)} {_how(exit_code)}")
            self._fork()
        self._note_end()

    def _note_end(self) -> None:
        away = (*self._down, *self._starting.held)
        may_come_back = any(told not in self._over for told, _ in away)
        if not self._robots and (self._ends or not may_come_back):
            self._all_ended.set()

    def _signal_all(self, number: signal.Signals) -> None:
        for pid in self._robots:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)

    def _become(self, place: Place, *, again: bool) -> None:
        """Run the robot in the forked child. Never returns: the caller's code is for the host."""
        exit_code: int = ExitCode.FAILED
        try:
            _forget_signals()
            os.close(self._lifeline_end)
            told, robot = place
            exit_code = run_robot(robot, told, self._lifeline, again=again, on_connected=self._tell_connected)
        except BaseException:
            for line in traceback.format_exc().splitlines():
                say(line)
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(exit_code)

    def _tell_connected(self) -> None:
        """In the forked child: it has a session."""
        os.write(self._connected_end, PID.pack(os.getpid()))


def _forget_signals() -> None:
    """Reset signal handling: the robot has inherited the host's handlers and wake-up pipe."""
    signal.set_wakeup_fd(-1)
    for number in HANDLED:
        signal.signal(number, signal.SIG_DFL)


def _how(exit_code: int) -> str:
    number = signal_of(exit_code) or -exit_code
    if number > 0:
        return f"was ended by {signal.Signals(number).name}"
    return f"ended with exit code {exit_code}"


def say(line: str) -> None:
    """Print a line to stderr for the user."""
    print(plain(line), file=sys.stderr, flush=True)  # noqa: T201 - the user reads it
