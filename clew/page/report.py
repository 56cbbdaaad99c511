"""Writes the page of a run as one file that requests nothing. A shell."""

from pathlib import Path

from clew.log.uncollected import uncollected
from clew.page.document import MARK, document
from clew.page.telling import Telling
from protocol.errors import UsageError
from protocol.files.writing import check_ours, make_folder, write_whole

REPORT_FILE = "report.html"


def write_report(run: Path, out: Path | None = None) -> tuple[Path, tuple[str, ...]]:
    """Write the page of a run, given its folder or its `events.jsonl`; returns its path, and the log's flaws.

    Raises:
        UsageError: there is no run, or the file cannot be written, or another file is in its place.
    """
    if not run.exists():
        raise UsageError(f"no run in {run}: there is no such file or folder")
    path = out or (run if run.is_dir() else run.parent) / REPORT_FILE
    if path.is_symlink():
        raise UsageError(f"cannot write {path}: it is there, and is a link")
    check_ours(path, MARK)
    telling = Telling(run)
    if not telling.is_there:
        raise UsageError(telling.flaws[0])  # no run: nothing is written into a folder that is none
    with uncollected():
        page = document([telling.batches()])
    try:
        if not path.parent.is_dir():
            make_folder(path.parent)
        write_whole(path, page.encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error
    return path, telling.flaws
