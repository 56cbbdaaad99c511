"""The output of an export: written under a temporary name first, so that nobody finds half an export.

Rule 1: only an earlier export is replaced: a file with the mark of ours, or a folder that holds only files
        with names that this export uses.
Rule 2: the hidden folder is locked while the export runs. A folder without a lock was left by an export that
        was killed; the next export to the same place removes it.
"""

import contextlib
import fcntl
import glob
import os
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

from protocol.errors import UsageError
from protocol.files.writing import FILE_MODE, check_ours, make_folder

PART = ".part"
NEW, OLD = "new", "old"


@contextmanager
def whole_file(out: Path, mark: bytes) -> Iterator[Path]:
    """A file to write. It becomes `out` on success; otherwise nothing is left of it.

    Args:
        out: its place.
        mark: what stands near the beginning of such a file of ours.

    Raises:
        UsageError: it cannot be written, or `out` is a folder, or a file that is not ours.
    """
    if out.is_dir():
        raise UsageError(f"{out}: it is a folder, and this export is one file")
    check_ours(out, mark)
    with _beside(out) as draft:
        yield draft / out.name
        (draft / out.name).chmod(FILE_MODE)
        (draft / out.name).replace(out)


@contextmanager
def whole_folder(out: Path, names: Collection[str]) -> Iterator[Path]:
    """A folder to fill. It becomes `out` on success; otherwise nothing is left of it.

    Raises:
        UsageError: it cannot be written, or `out` holds something other than files of these names.
    """
    if out.exists() and not out.is_dir():
        raise UsageError(f"{out}: it is no folder, and this export is one")
    foreign = _foreign(out, names)
    if foreign is not None:
        raise UsageError(
            f"{out}: it holds {foreign}, which is not part of an earlier export and would be lost"
        )
    with _beside(out) as draft:
        filled = draft / NEW
        make_folder(filled)
        yield filled
        for each in filled.iterdir():
            each.chmod(FILE_MODE)
        if out.exists():
            out.rename(draft / OLD)
        filled.rename(out)


def _foreign(out: Path, names: Collection[str]) -> str | None:
    """The name of something at `out` that no export has written; None if there is nothing like that."""
    if not out.is_dir():
        return None
    return next((each.name for each in out.iterdir() if each.name not in names or not each.is_file()), None)


@contextmanager
def _beside(out: Path) -> Iterator[Path]:
    """A hidden folder on the same file system; it is removed with everything left in it."""
    # Named before it is made: an interrupt right after that would leave a folder whose name nobody knows.
    draft = out.parent / f".{out.name}.{uuid4().hex}{PART}"
    try:
        if not out.parent.is_dir():
            make_folder(out.parent)
        for left in out.parent.glob(f".{glob.escape(out.name)}.*{PART}"):
            _clear(left, {NEW, OLD, out.name})
        make_folder(draft)
        with _locked(draft):
            yield draft
    except OSError as error:
        raise UsageError(f"{out}: cannot be written: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            shutil.rmtree(draft)


def _clear(left: Path, ours: Collection[str]) -> None:
    """Rule 2: remove a leftover. A folder that holds anything other than these names is not ours."""
    with contextlib.suppress(OSError):  # another export may be removing it or have locked it
        if all(each.name in ours for each in left.iterdir()):
            with _locked(left):
                shutil.rmtree(left)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Lock a folder until the end of the context or of this process.

    Raises:
        OSError: another process has locked it.
    """
    held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(held)
