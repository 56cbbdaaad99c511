"""Where an export is written: under a name of its own first, so that nobody finds half of one.

Rule 1: what is replaced is a former export: a file, or a folder of files, with the export's own suffix.
"""

import contextlib
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from protocol.errors import UsageError


@contextmanager
def whole_file(out: Path) -> Iterator[Path]:
    """A file to write, which becomes `out` when all went well; else nothing is left of it.

    Raises:
        UsageError: it cannot be written, or `out` is no file.
    """
    if out.is_dir():
        raise UsageError(f"--out {out}: it is a folder, and this export is one file")
    with _beside(out) as draft:
        yield draft / out.name
        (draft / out.name).replace(out)


@contextmanager
def whole_folder(out: Path, suffix: str) -> Iterator[Path]:
    """A folder to fill, which becomes `out` when all went well; else nothing is left of it.

    Raises:
        UsageError: it cannot be written, or `out` holds something else than files with this suffix.
    """
    if out.exists() and not (out.is_dir() and all(each.suffix == suffix for each in out.iterdir())):
        raise UsageError(f"--out {out}: it holds something else than {suffix} files, which would be lost")
    with _beside(out) as draft:
        filled = draft / "new"
        filled.mkdir()
        yield filled
        if out.exists():
            out.rename(draft / "old")
        filled.rename(out)


@contextmanager
def _beside(out: Path) -> Iterator[Path]:
    """A hidden folder on the same file system, which goes away with all that is left in it."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=f".{out.name}.", suffix=".part", dir=out.parent))
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written: {error.strerror}") from error
    try:
        yield draft
    except OSError as error:
        raise UsageError(f"--out {out}: cannot be written: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            shutil.rmtree(draft)
