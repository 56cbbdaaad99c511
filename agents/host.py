"""A host of robots: forks one process for each before any session is opened, and reaps them.

Rule 1: a robot that dies is reaped and said; the others live on.
Rule 2: asked to end, the host asks all its robots, waits, and kills what is left.
Rule 3: a robot outlives its host by no more than a moment: it holds the reading end of a pipe whose
        writing end is the host's alone.
"""

import asyncio
import contextlib
import gc
import os
import signal
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from agents.shell import run
from protocol.ending import asked_to_end, until_ended
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.keys import robot_name
from protocol.session import read_session

KILL_AFTER_S = 2.0  # wall: a fleet has 5 s to end, and its launcher wants some of that


def run_robot(robot: int, sessions: Path, lifeline: int | None) -> int:
    """Run one robot in this process; returns the exit code.

    Args:
        robot: its number.
        sessions: folder of the run's session files.
        lifeline: a file descriptor; the robot ends when the other end is closed.
    """
    try:
        session = read_session(sessions / f"{robot_name(robot)}.json")
        return asyncio.run(until_ended(run(robot, session), lifeline))
    except UsageError as error:
        _say(f"robot {robot}: {error}")
        return ExitCode.USAGE


def run_host(robots: Sequence[int], sessions: Path, lifeline: int | None) -> int:
    """Fork the robots and reap them; returns 0 when all ended well, else the first bad exit code."""
    reading_end, writing_end = os.pipe()
    gc.freeze()  # what is loaded by now stays shared: the collector would touch, and so copy, every page
    forked: dict[int, int] = {}
    for robot in robots:
        pid = os.fork()
        if pid == 0:
            os.close(writing_end)
            _become(robot, sessions, reading_end)
        forked[pid] = robot
    os.close(reading_end)
    with os.fdopen(writing_end):
        return asyncio.run(_Host(forked).reap(lifeline))


def _become(robot: int, sessions: Path, lifeline: int) -> None:
    """The forked child: never returns, since what follows in the caller is the host's."""
    exit_code: int = ExitCode.FAILED
    try:
        exit_code = run_robot(robot, sessions, lifeline)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(exit_code)


class _Host:
    """Who is still running, and how the others ended."""

    def __init__(self, robots: dict[int, int]) -> None:
        self._robots = robots
        self._exit_code: int = ExitCode.OK
        self._all_ended = asyncio.Event()

    async def reap(self, lifeline: int | None) -> int:
        """Wait until all robots have ended, asking them to when we are asked to."""
        loop = asyncio.get_running_loop()
        loop.add_signal_handler(signal.SIGCHLD, self._reap)
        self._reap()  # those that ended before there was a handler
        with asked_to_end(lifeline) as asked:
            ended = asyncio.ensure_future(self._all_ended.wait())
            either: list[asyncio.Future[Any]] = [ended, asked]
            await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            if ended.done():
                return self._exit_code
            self._tell(signal.SIGTERM)
            await asyncio.wait([ended], timeout=KILL_AFTER_S)
            self._tell(signal.SIGKILL)
            await ended
            return asked.result()

    def _reap(self) -> None:
        while self._robots:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            robot, exit_code = self._robots.pop(pid), os.waitstatus_to_exitcode(status)
            if exit_code != 0:
                self._exit_code = self._exit_code or max(exit_code, ExitCode.FAILED)  # a signal's is negative
                _say(f"robot {robot} {_how(exit_code)}")
        self._all_ended.set()

    def _tell(self, number: signal.Signals) -> None:
        for pid in self._robots:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)


def _how(exit_code: int) -> str:
    if exit_code < 0:
        return f"was ended by {signal.Signals(-exit_code).name}"
    return f"ended with exit code {exit_code}"


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)  # noqa: T201 - the user reads it
