"""The private folder of a run, and the lifeline that all its parts hold.

Rule 1: the folder is removed when the run ends. If we are killed, the cleaner removes it.
Rule 2: the lifeline is a pipe that carries no data. Its reading end is the stdin of every part and of the
        cleaner; only we hold the writing end. End of file means that we are gone: then the parts end.
Rule 3: a frozen part cannot read, so the cleaner thaws all parts. The kernel does so only where they are in
        another session than the process that adopts them, which does not hold in every container.
"""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from protocol.errors import UsageError

PATH_BYTES_MAX = 80  # of the parent folder: the whole path of a socket may have 107 bytes
FALLBACK = Path("/tmp")  # noqa: S108 - mkdtemp makes a folder in it that only the user can enter

# A shell takes the least memory. It reads the process ids from files that `processes.py` writes.
CLEANER = """
read -r _
for file in "$1"/*.pid; do read -r pid <"$file" && kill -s CONT -- "-$pid"; done 2>/dev/null
rm -rf -- "$1"
"""


@dataclass(frozen=True, slots=True)
class Private:
    """The private resources of a run."""

    folder: Path
    lifeline: int
    """The reading end of the lifeline."""


@contextmanager
def private_folder(temporary: str | None) -> Iterator[Private]:
    """A folder that only the user can enter, and a lifeline, while the context lasts.

    Args:
        temporary: the folder for temporary files; None: `/tmp`.

    Raises:
        UsageError: no folder can be made there.
    """
    above = Path(temporary or FALLBACK).absolute()
    if len(os.fsencode(above)) > PATH_BYTES_MAX:
        above = FALLBACK
    try:
        folder = Path(tempfile.mkdtemp(prefix="clew.", dir=above))
    except OSError as error:
        raise UsageError(
            f"no folder for the run's sockets can be made in {above}: {error.strerror}"
        ) from error
    reading_end, writing_end = os.pipe()
    cleaner = subprocess.Popen(  # noqa: S603 - a shell with our own script, and a path as its argument
        ["/bin/sh", "-c", CLEANER, "cleaner", folder],
        stdin=reading_end,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        process_group=0,  # Ctrl-C reaches only us
    )
    try:
        yield Private(folder, reading_end)
    finally:
        cleaner.kill()
        cleaner.wait()
        os.close(reading_end)
        os.close(writing_end)
        shutil.rmtree(folder, ignore_errors=True)
