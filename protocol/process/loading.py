"""Ctrl-C while a program starts: it ends the process, without the traceback of an import.

Rule 1: a program may hold interrupts back from its first line on, or be started with SIGINT blocked, as our
        scripts do: before its first line Python itself would print a traceback, and exit with 1.
Rule 2: what is held back is heard as soon as something is done that can be interrupted.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread


@contextmanager
def loading() -> Iterator[None]:
    """In this context SIGINT ends the process; afterwards it raises KeyboardInterrupt again."""
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler and current_thread() is main_thread()
    if ours:  # else it is ignored, or somebody else's
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def hold_interrupts() -> None:
    """Hold SIGINT back from now on (rule 1)."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


@contextmanager
def interruptible() -> Iterator[None]:
    """In this context SIGINT is heard, also one that was held back; afterwards it is held back as before."""
    before = signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
