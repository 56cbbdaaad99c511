"""Writes files that only the user may read: a run shows the positions of robots.

Rule 1: files have mode 0600, and folders that we create 0700, for any umask.
Rule 2: nothing is written through a link: a link in the place of a file is replaced, and its target stays
        unchanged. Anything but a file or a link is refused.
Rule 3: writing a whole file is atomic: the file is complete, or as before.
Rule 4: in a place that a user names, only files of ours are replaced, and empty ones, as mktemp makes them.
"""

import errno
import os
import secrets
import stat
from io import FileIO
from pathlib import Path

from protocol.errors import UsageError
from protocol.files.opening import MADE_BYTES_MAX, open_regular, read_bytes

FILE_MODE, FOLDER_MODE = 0o600, 0o700
MARK_BYTES = 4096  # at each end of a file: of ours, a page has its mark at byte 90, a PDF 900 from the end


def make_folder(folder: Path) -> None:
    """Create a folder and its missing parents; existing folders stay unchanged.

    Raises:
        OSError: it cannot be created, or a link or a file is in its place.
    """
    if not folder.parent.is_dir():
        make_folder(folder.parent)
    try:
        folder.mkdir(mode=FOLDER_MODE)
    except FileExistsError as error:
        if not stat.S_ISDIR(folder.lstat().st_mode):
            raise FileExistsError(errno.EEXIST, f"{folder} is no folder", str(folder)) from error
    else:
        folder.chmod(FOLDER_MODE)


def open_private(path: Path, mode: str) -> FileIO:
    """Open a file unbuffered, in a mode of `open`: `x` creates, `a` creates or appends, `r+` changes.

    Raises:
        OSError: it cannot be opened in this mode, or is a link.
    """
    return FileIO(str(path), mode, opener=_opener)


def sync_folder(folder: Path) -> None:
    """The names of new files in this folder survive a power cut.

    Raises:
        OSError: the disk cannot write them.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file in one atomic step, replacing a file or a link.

    Raises:
        OSError: it cannot be written, or its place is taken by something else; `filename` is this path.
    """
    if os.path.lexists(path) and stat.S_IFMT(path.lstat().st_mode) not in {stat.S_IFREG, stat.S_IFLNK}:
        raise OSError(errno.EEXIST, "it is there, and is no file", str(path))
    part = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with open_private(part, "x") as file:
            while content:  # on a full disk a write may be partial before the next one fails
                content = content[file.write(content) :]
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error


def check_ours(path: Path, mark: bytes) -> None:
    """Refuse to replace a file that is not ours (rule 4).

    Args:
        path: its place; nothing has to be there.
        mark: what stands near the beginning or the end of each such file of ours.

    Raises:
        UsageError: it is not ours, or cannot be read.
    """
    try:
        with open_regular(path) as file:
            ends = file.read(MARK_BYTES)
            file.seek(max(len(ends), file.seek(0, os.SEEK_END) - MARK_BYTES))
            ends += file.read(MARK_BYTES)
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error
    if ends and mark not in ends:
        raise would_be_lost(path)


def check_same(path: Path, content: bytes) -> None:
    """Refuse to replace a file that has another content, unless it is empty (rule 4).

    Raises:
        UsageError: it has, or cannot be read.
    """
    try:
        is_same = read_bytes(path, MADE_BYTES_MAX) in {b"", content}
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error
    if not is_same:
        raise would_be_lost(path)


def would_be_lost(path: Path) -> UsageError:
    """The refusal to replace a file that is not ours (rule 4)."""
    return UsageError(f"cannot write {path}: it is there, and bears no mark of Clew, so it would be lost")


def _opener(path: str, flags: int) -> int:
    descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NOCTTY | os.O_NONBLOCK, FILE_MODE)
    try:
        if flags & os.O_CREAT:
            os.fchmod(descriptor, FILE_MODE)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor
