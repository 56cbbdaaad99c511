"""Opens what a user has named, or what stands in a run's folder, which may be anybody's.

Rule 1: only regular files are read. A FIFO would be waited for without an end, and a device has no end.
Rule 2: no more of a file is read at once than its limit.
"""

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path

WRITTEN_BYTES_MAX = 8 << 20
"""Of a file that people write: a scenario with 10,000 polygons takes less."""
MADE_BYTES_MAX = 256 << 20
"""Of a file that we have written in one piece: a campaign of 100,000 episodes takes less."""


def open_regular(path: Path) -> BufferedReader:
    """The file, to be read.

    Raises:
        OSError: it is not there, may not be read, or is no regular file.
    """
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
    """All of a regular file.

    Raises:
        OSError: as above, or it is longer than its limit.
    """
    with open_regular(path) as file:
        text = file.read(bytes_max + 1)
    if len(text) > bytes_max:
        raise OSError(errno.EFBIG, f"it is longer than {bytes_max} bytes", str(path))
    return text
