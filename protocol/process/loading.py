"""Ctrl-C while a program starts ends the process, without the traceback of an import.

Rule 1: a program may hold SIGINT back from its first line on. Our scripts start it with SIGINT blocked, since
        before that line Python itself would print a traceback and exit with 1.
Rule 2: a SIGINT that was held back is heard as soon as work begins that can be interrupted.
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
    """SIGINT is heard in this context, also one that was held back; after it the mask is as before."""
    before = signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
