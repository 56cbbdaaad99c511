"""`clew bench page`: writes docs/performance.md from results of benchmarks."""

from pathlib import Path

import click

from clew.verbs.options import PATH
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.root import ROOT

RESULTS = ROOT / "docs" / "performance"
PAGE = ROOT / "docs" / "performance.md"


@click.command()
@click.argument("results", nargs=-1, type=PATH)
@click.option("--out", type=PATH, help="The page to write; default: docs/performance.md.")
def page(results: tuple[Path, ...], out: Path | None) -> None:
    """Write a page of figures from RESULTS: what `clew bench ... --json` printed.

    The missed aims stand first. Default: all files in docs/performance.
    """
    from clew.bench.page import MARK
    from clew.bench.page import page as page_of
    from clew.bench.result import Result
    from protocol.files.reading import read, understand
    from protocol.files.writing import check_ours

    asked = results or sorted(RESULTS.glob("*.json"))
    if not asked:
        raise UsageError(f"{RESULTS}: has no results")
    written = out or PAGE
    known = [understand(read(path, str(path)), Result, str(path)) for path in asked]
    try:
        check_ours(written, MARK.encode())
        written.write_text(page_of(known), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write {written}: {error.strerror}") from error
    warn(f"wrote {written}")
