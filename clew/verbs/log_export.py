"""`clew log export`: writes a timeline for other tools."""

import json
from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.extras import need
from clew.verbs.options import AS_JSON, PATH, Word
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.export.exported import Exported

FORMATS = {
    "mcap": ("foxglove", "clew.export.mcap_file", "events.mcap"),
    "csv": (None, "clew.export.csv_files", "csv"),
    "parquet": ("pyarrow", "clew.export.parquet", "parquet"),
}
"""For each format: the library it needs, the module that writes it, and its name in the run's folder."""


@click.command()
@click.argument("run", type=PATH)
@click.option("--to", "to", type=Word(list(FORMATS)), required=True, help="Format of the export.")
@click.option("--out", type=PATH, help="The file to write; for csv and parquet, the folder.")
@AS_JSON
@terminable()
def export(run: Path, *, to: str, out: Path | None, as_json: bool) -> None:
    """Export a timeline as MCAP, CSV or Parquet, by default into the run's folder.

    An earlier export is replaced. Parts of the log that cannot be read are named on stderr and left out.
    """
    from clew.log.log import Log

    needed, writer, name = FORMATS[to]
    log = Log(run)  # first: what cannot be exported needs no library
    if needed is not None:
        need(needed, extra=to, by="this export needs")
    place = log.path.parent / name if out is None else out
    if Path(name).suffix and place.suffix != Path(name).suffix:
        raise UsageError(f"--out {place}: its name must end in {Path(name).suffix}")
    exported: Exported = import_module(writer).export(log, place)
    if as_json:
        click.echo(json.dumps({"out": str(place)} | asdict(exported)))
    else:
        click.echo(place)
    for flaw in exported.flaws:
        warn(f"not complete: {flaw}")
