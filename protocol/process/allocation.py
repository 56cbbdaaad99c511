"""What a process asks of the allocator of glibc. Another C library has no such settings, and none is needed.

Both settings are inherited by processes that are forked, and cost nothing where little is allocated.
"""

import contextlib
import ctypes

M_MMAP_THRESHOLD, M_ARENA_MAX = -3, -8  # their numbers in malloc.h
LARGE_BYTES = 1 << 17  # glibc's own value, until it adapts to what is freed


def allocate_from_one_arena() -> None:
    """Keep memory from growing with each session; to be called before Zenoh starts its threads.

    glibc gives threads arenas of their own, 15 in a router, and what one has freed another does not use:
    after 140 restarts of robots in 150 s, 10 of 27 MB were free. With one arena it was 1 of 18.
    """
    _set(M_ARENA_MAX, 1)


def return_large_blocks() -> None:
    """Return each large block to the system as soon as it is freed.

    glibc would keep blocks as large as the largest that was freed before. A robot that had led on ground of
    282 m kept 12 to 21 MB of a map that it had given up; now it keeps 5.
    """
    _set(M_MMAP_THRESHOLD, LARGE_BYTES)


def _set(parameter: int, value: int) -> None:
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).mallopt(parameter, value)
