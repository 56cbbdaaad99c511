"""`clew log export`: a timeline for other tools."""

import json
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

import click

from clew.export.exported import Exported
from clew.log.log import Log
from clew.verbs.extras import need
from clew.verbs.options import AS_JSON
from clew.verbs.say import warn
from protocol.asked import terminable
from protocol.errors import UsageError

FORMATS = {
    "mcap": ("foxglove", "clew.export.mcap_file", "events.mcap"),
    "csv": (None, "clew.export.csv_files", "csv"),
    "parquet": ("pyarrow", "clew.export.parquet", "parquet"),
}
"""What has to be installed, what writes it, and what it is called in the run's folder."""


@click.command()
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--to", "to", type=click.Choice(list(FORMATS)), required=True, help="What to make of it.")
@click.option(
    "--out", type=click.Path(path_type=Path), help="The file, or for csv and parquet the folder, to write."
)
@AS_JSON
@terminable()
def export(run: Path, *, to: str, out: Path | None, as_json: bool) -> None:
    """Write a timeline as MCAP, CSV or Parquet; by default into the run's folder.

    A former export is replaced. Whatever cannot be read of the log is said and left out.
    """
    needed, writer, name = FORMATS[to]
    if needed is not None:
        need(needed, extra=to, by="this export needs")
    log = Log(run)
    place = log.path.parent / name if out is None else out
    if Path(name).suffix and place.suffix != Path(name).suffix:
        raise UsageError(f"--out {place}: the name of such a file ends in {Path(name).suffix}")
    exported: Exported = import_module(writer).export(log, place)
    if as_json:
        click.echo(json.dumps({"out": str(place)} | asdict(exported)))
    else:
        click.echo(place)
    for flaw in exported.flaws:
        warn(f"not complete: {flaw}")
