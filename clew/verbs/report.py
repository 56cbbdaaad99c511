"""`clew report`: one HTML file that shows a run."""

import contextlib
import gc
from collections.abc import Iterator
from pathlib import Path

import click

from clew.page.document import document, is_document
from clew.story.telling import Telling
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.files.writing import write_whole

REPORT_FILE = "report.html"


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help=f"Default: {REPORT_FILE} beside the log.")
def report(run: Path, *, out: Path | None) -> None:
    """Make one HTML file of a run, which shows what happened and why; it opens anywhere, requests nothing.

    RUN is a run's folder, or its events.jsonl. Prints the file's path. Replaces nothing but a report.
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
    """Without looking for cycles: entries are in none, and it takes a sixth of the time of a long log."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
