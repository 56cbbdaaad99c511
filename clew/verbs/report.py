"""`clew report`: writes one HTML file that shows a run."""

import contextlib
import gc
from collections.abc import Iterator
from pathlib import Path

import click

from clew.page.document import document, is_document
from clew.page.telling import Telling
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.files.writing import write_whole

REPORT_FILE = "report.html"


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--out", type=click.Path(path_type=Path), help=f"File to write; default: {REPORT_FILE} beside the log."
)
def report(run: Path, *, out: Path | None) -> None:
    """Write one HTML file that shows what happened in a run, and why.

    RUN is the folder of a run, or its events.jsonl. The file opens in any browser and requests nothing from
    the network. The verb prints its path. It replaces an earlier report, but no other file.
    """
    if not run.exists():
        raise UsageError(f"no run in {run}: there is no such file or folder")
    path = out or (run if run.is_dir() else run.parent) / REPORT_FILE
    if path.is_symlink() or (path.is_file() and not is_document(path)):
        raise UsageError(f"cannot write {path}: it is there, and no report that could be replaced")
    telling = Telling(run)
    if not telling.is_there:
        raise UsageError(telling.flaws[0])  # no run: nothing is written into a folder that is none
    with _uncollected():
        page = document([telling.batches()])
    try:
        write_whole(path, page.encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error
    for flaw in telling.flaws:
        warn(f"not complete: {flaw}")
    click.echo(str(path))


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Switch off the search for reference cycles: it takes a sixth of the time, and entries are in none."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
