"""Runs a piece of work in a fork of this process, and hands back what it returns. A shell.

Rule 1: the parent waits: of all processes of a tree at most one works.
Rule 2: a fork ends with its work, whatever happens in it, with the wait for it, and with its parent. It holds
        all open files of its parent, so who waits for their end would wait for the fork, too.
"""

import ctypes
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from typing import NoReturn

PR_SET_PDEATHSIG = 1  # of Linux: prctl(2)


def in_a_fork(work: Callable[[], bytes]) -> bytes | None:
    """What the work returns there; None if the fork dies."""
    ours, theirs = Pipe(duplex=False)
    parent, prctl = os.getpid(), ctypes.CDLL(None).prctl
    child = os.fork()
    if child == 0:
        prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it has ended meanwhile
            os._exit(1)
        ours.close()
        _work(work, theirs.send_bytes)
    theirs.close()
    try:
        return ours.recv_bytes()
    except EOFError:
        return None
    finally:
        ours.close()
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)  # it has sent what it had, or never will
        os.waitpid(child, 0)


def _work(work: Callable[[], bytes], send: Callable[[bytes], None]) -> NoReturn:
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent
        send(work())
    finally:
        os._exit(0)
