"""Sends process faults to the parents of the processes, through the run's private folder. A shell.

Rule 1: the folder has mode 0700, so only the user can inject a process fault.
Rule 2: each host of robots has a socket in the folder and reads one command per datagram. The launcher has a
        pipe and reads one command per line. The sender waits for neither.
Rule 3: the launcher itself ends a fault of the world or the router after the time in the command. The world
        cannot do it: it has no clock while it is stopped, and its clock hardly moves in lock-step without a
        router.
"""

import contextlib
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import msgspec
from msgspec import Struct

from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.frames import RobotId
from protocol.keys import robot_number

SOCKETS = "h*.sock"  # `*` is the host's first robot; a socket path may have 107 bytes at most
PIPE = "process-faults"
COMMAND_BYTES_MAX = 200  # a command takes less than 60


class HostCommand(Struct, frozen=True, kw_only=True):
    """A process fault that a host applies to one of its robots."""

    action: ProcessAction
    robot: RobotId
    done: bool = False
    """The robot applies the fault to itself; the host only has to know that its end is no failure."""


def send_process_fault(folder: Path, fault: ProcessFault, *, speed: float) -> None:
    """Send a process fault to the parent of the process; it is lost where no parent listens.

    Args:
        folder: the run's private folder.
        fault: the action and the process.
        speed: simulated seconds per wall-clock second.
    """
    robot = robot_number(fault.process)
    if robot is not None:
        send_to_hosts(folder, HostCommand(action=fault.action, robot=robot))
    else:
        wall_s = "" if fault.for_s is None else f" {fault.for_s / speed:.3f}"
        _tell_launcher(folder, f"{fault.action} {fault.process}{wall_s}\n")


def send_to_hosts(folder: Path, command: HostCommand) -> None:
    """Send a command to all hosts; each host knows its own robots."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        for path in sorted(folder.glob(SOCKETS)):
            with contextlib.suppress(OSError):  # a host that has ended, or is frozen with a full socket
                sender.sendto(msgspec.json.encode(command), str(path))


@contextlib.contextmanager
def command_socket(folder: Path, first_robot: int) -> Iterator[socket.socket]:
    """The socket on which a host receives its commands."""
    path = folder / SOCKETS.replace("*", str(first_robot))
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.setblocking(False)
        listening.bind(str(path))
        try:
            yield listening
        finally:
            path.unlink(missing_ok=True)


def received_commands(listening: socket.socket) -> Iterator[HostCommand]:
    """All commands that have arrived. Invalid datagrams are skipped: only the user could have sent one."""
    while True:
        try:
            said = listening.recv(COMMAND_BYTES_MAX)
        except BlockingIOError:
            return
        with contextlib.suppress(msgspec.MsgspecError):
            yield msgspec.json.decode(said, type=HostCommand)


def _tell_launcher(folder: Path, line: str) -> None:
    with contextlib.suppress(OSError):  # there is no pipe, or nothing reads it
        descriptor = os.open(folder / PIPE, os.O_WRONLY | os.O_NONBLOCK)
        try:
            os.write(descriptor, line.encode())
        finally:
            os.close(descriptor)
