"""Writes what only the user is to read: a run shows where robots are.

Rule 1: files have mode 0600 and folders that we make 0700, whatever the umask.
Rule 2: nothing is written through a link: a link that stands where a file is to be is replaced, its target is
        left alone. What is neither file nor link is refused.
Rule 3: a file that is written whole is there whole, or is as it was.
"""

import errno
import os
import secrets
import stat
from io import FileIO
from pathlib import Path

FILE_MODE, FOLDER_MODE = 0o600, 0o700


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it that are missing; one that is there stays as it is.

    Raises:
        OSError: it cannot be made, or a link or a file is there.
    """
    if not folder.parent.is_dir():
        make_folder(folder.parent)
    try:
        folder.mkdir(mode=FOLDER_MODE)
    except FileExistsError:
        if not stat.S_ISDIR(folder.lstat().st_mode):
            raise
    else:
        folder.chmod(FOLDER_MODE)


def open_private(path: Path, mode: str) -> FileIO:
    """The file, unbuffered, in a mode as of `open`: `x` makes it, `a` makes it or goes on, `r+` changes it.

    Raises:
        OSError: it cannot be opened so, or is a link.
    """
    return FileIO(str(path), mode, opener=_opener)


def write_whole(path: Path, content: bytes) -> None:
    """Put a file there in one step, in the place of a file or a link.

    Raises:
        OSError: it cannot be written, or what is there is neither.
    """
    if os.path.lexists(path) and stat.S_IFMT(path.lstat().st_mode) not in {stat.S_IFREG, stat.S_IFLNK}:
        raise OSError(errno.EEXIST, "it is there, and is no file", str(path))
    part = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with open_private(part, "x") as file:
            while content:  # a write to a full disk may be cut short before the next one fails
                content = content[file.write(content) :]
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def _opener(path: str, flags: int) -> int:
    descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NOCTTY | os.O_NONBLOCK, FILE_MODE)
    try:
        if flags & os.O_CREAT:
            os.fchmod(descriptor, FILE_MODE)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor
