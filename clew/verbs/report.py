"""`clew report`: writes one HTML file that shows a run."""

from pathlib import Path

import click

from clew.verbs.options import PATH
from clew.verbs.say import warn


@click.command()
@click.argument("run", type=PATH)
@click.option("--out", type=PATH, help="File to write; default: report.html beside the log.")
def report(run: Path, *, out: Path | None) -> None:
    """Write one HTML file that shows what happened in a run, and why.

    RUN is the folder of a run, or its events.jsonl. The file opens in any browser and requests nothing from
    the network. The verb prints its path. It replaces an earlier report, but no other file.
    """
    from clew.page.report import write_report

    path, flaws = write_report(run, out)
    for flaw in flaws:
        warn(f"not complete: {flaw}")
    click.echo(str(path))
