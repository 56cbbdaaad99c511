"""What is to be done to processes, told to whoever started them: through the run's private folder. A shell.

Rule 1: only who may write into that folder (0700: the user) can strike anybody.
Rule 2: a host of robots has a socket there, and hears one order a datagram; the launcher, which is bash, has
        a pipe, and hears one a line. Nobody waits for either.
Rule 3: the launcher itself undoes what it has done to world and router, after the time that it is told: the
        world has no time while it is away, and little in lock-step while there is no router.
"""

import contextlib
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import msgspec
from msgspec import Struct

from protocol.faults.process_faults import Blow, Stroke
from protocol.frames import RobotId
from protocol.keys import robot_number

SOCKETS = "h*.sock"  # a host's carries its first robot's number; a longer name might not fit (107 bytes)
PIPE = "strokes"
ORDER_BYTES_MAX = 200  # they take less than 60


class HostOrder(Struct, frozen=True, kw_only=True):
    """What a host is to do to one of its robots."""

    blow: Blow
    robot: RobotId
    done: bool = False
    """The robot does it to itself: its host only has to know that it was meant to be."""


def strike(folder: Path, stroke: Stroke, *, speed: float) -> None:
    """Have whoever started a process do this to it; nothing happens where nobody listens.

    Args:
        folder: the run's private folder.
        stroke: what to do, and to whom.
        speed: simulated seconds per wall-clock second.
    """
    robot = robot_number(stroke.process)
    if robot is not None:
        tell_hosts(folder, HostOrder(blow=stroke.blow, robot=robot))
    else:
        wall_s = "" if stroke.for_s is None else f" {stroke.for_s / speed:.3f}"
        _tell_launcher(folder, f"{stroke.blow} {stroke.process}{wall_s}\n")


def tell_hosts(folder: Path, order: HostOrder) -> None:
    """Tell all hosts; each knows which robots are its own."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        for path in sorted(folder.glob(SOCKETS)):
            with contextlib.suppress(OSError):  # one that has gone, or is itself frozen with a full socket
                sender.sendto(msgspec.json.encode(order), str(path))


@contextlib.contextmanager
def ear(folder: Path, first_robot: int) -> Iterator[socket.socket]:
    """The socket by which a host hears what it is to do."""
    path = folder / SOCKETS.replace("*", str(first_robot))
    path.unlink(missing_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.setblocking(False)
        listening.bind(str(path))
        try:
            yield listening
        finally:
            path.unlink(missing_ok=True)


def orders(listening: socket.socket) -> Iterator[HostOrder]:
    """All orders that have come; what is none is left out, since only the user could have sent it."""
    while True:
        try:
            said = listening.recv(ORDER_BYTES_MAX)
        except BlockingIOError:
            return
        with contextlib.suppress(msgspec.MsgspecError):
            yield msgspec.json.decode(said, type=HostOrder)


def _tell_launcher(folder: Path, line: str) -> None:
    with contextlib.suppress(OSError):  # no pipe, or nobody who reads it
        descriptor = os.open(folder / PIPE, os.O_WRONLY | os.O_NONBLOCK)
        try:
            os.write(descriptor, line.encode())
        finally:
            os.close(descriptor)
