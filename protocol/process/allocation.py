"""What a process asks of the allocator of glibc. Another C library has no such settings, and none is needed.

Settings are inherited by processes that are forked, and cost nothing where little is allocated.
"""

import contextlib
import ctypes
import sys

M_MMAP_THRESHOLD, M_ARENA_MAX = -3, -8  # their numbers in malloc.h
LARGE_BYTES = 1 << 17  # glibc's own value, until it adapts to what is freed
HOLE_BYTES_MAX, HOLE_BYTES_MIN = 1 << 16, 24  # larger ones are few; glibc has no smaller block
SMALL_BYTES_MAX, STEP_BYTES = 1100, 16  # of each smaller size, 16 apart, glibc keeps some for itself


def allocate_from_one_arena() -> None:
    """Keep memory from growing with each session; to be called before Zenoh starts its threads.

    glibc gives threads arenas of their own, 15 in a router and 8 in a world, and no arena uses what another
    one has freed: after 140 restarts of robots in 150 s, 10 of 27 MB of a router were free. With one arena it
    was 1 of 18.
    """
    _set(M_ARENA_MAX, 1)


def return_large_blocks() -> None:
    """Return each large block to the system as soon as it is freed.

    glibc would keep blocks as large as the largest that was freed before. A robot that had led on ground of
    282 m kept 12 to 21 MB of a map that it had given up; now it keeps 5.
    """
    _set(M_MMAP_THRESHOLD, LARGE_BYTES)


def forget_lookups() -> None:
    """Empty Python's cache of attributes of types: call it before robots are forked.

    It keeps the names of the last 4,096 lookups, most of them of libraries as they were loaded. Each lookup
    of a robot would let go of one, and so write into a page that all robots share.
    """
    with contextlib.suppress(AttributeError):
        sys._clear_type_cache()  # of CPython alone


def fill_holes() -> None:
    """Take all free blocks between others, for good: call it before robots are forked.

    What a forked process allocates would lie in such holes, each on a page that it had shared until then. Now
    it lies together, on pages of its own. glibc writes into the holes' neighbours, too, when it uses them.
    """
    libc, size = ctypes.CDLL(None), ctypes.c_size_t
    with contextlib.suppress(AttributeError):
        allocate = ctypes.CFUNCTYPE(size, size)(("malloc", libc))
        free = ctypes.CFUNCTYPE(None, size)(("free", libc))
        move_end = ctypes.CFUNCTYPE(size, ctypes.c_ssize_t)(("sbrk", libc))
        info = ctypes.CFUNCTYPE(_Info)(("mallinfo2", libc))
        size_bytes = HOLE_BYTES_MAX
        while size_bytes >= HOLE_BYTES_MIN:
            end = move_end(0) - info().keepcost  # where the last block ends
            while 0 < (block := allocate(size_bytes)) < end:  # 0: there is no memory left
                pass
            free(block)  # it has filled no hole
            size_bytes -= STEP_BYTES if size_bytes <= SMALL_BYTES_MAX else size_bytes // 8


class _Info(ctypes.Structure):
    """`struct mallinfo2` of malloc.h."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    )


def _set(parameter: int, value: int) -> None:
    with contextlib.suppress(AttributeError):
        ctypes.CDLL(None).mallopt(parameter, value)
