"""The state that Python keeps of a thread which it has not started, such as Zenoh's.

Python makes it when such a thread calls, and ends it when the call returns. So each call maps the memory of a
stack and unmaps it again, which also interrupts the other threads of the process.
"""

import ctypes
import threading


class _Kept(threading.local):
    """Made at its first use in a thread; where Python forgets the thread, it forgets this, too."""

    def __init__(self) -> None:
        ctypes.pythonapi.PyGILState_Ensure()  # released by nobody, so the state stays


_kept = _Kept()


def keep_thread() -> None:
    """Keep the state of the thread that calls this, until the process ends. Calling it again does nothing."""
    vars(_kept)
