"""Opens files that a user has named, or that are in a run's folder, which may belong to another user.

Rule 1: only regular files are read. A FIFO could block for ever, and a device has no end.
Rule 2: at most the size limit of a file is read.
"""

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path

WRITTEN_BYTES_MAX = 8 << 20
"""For files written by users: a scenario with 10,000 polygons is smaller."""
MADE_BYTES_MAX = 256 << 20
"""For files written by Clew in one piece: a campaign of 100,000 episodes is smaller."""


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading.

    Raises:
        OSError: it is missing, not readable, or not a regular file; or no file can have this name.
    """
    if "\0" in str(path):  # as a name in a scenario may have it; `os.open` raises a ValueError
        raise OSError(errno.EINVAL, "no file can have this name", str(path))
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOCTTY)
    try:
        kind = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(kind):
            raise OSError(errno.EINVAL, "it is no regular file", str(path))
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


def read_bytes(path: Path, bytes_max: int) -> bytes:
    """Read a whole regular file.

    Raises:
        OSError: see `open_regular`; or it is longer than its limit.
    """
    with open_regular(path) as file:
        text = file.read(bytes_max + 1)
    if len(text) > bytes_max:
        raise OSError(errno.EFBIG, f"it is longer than {bytes_max} bytes", str(path))
    return text
