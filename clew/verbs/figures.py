"""`clew figures`: draws a run or a campaign for print."""

import json
from pathlib import Path

import click

from clew.verbs.extras import need
from clew.verbs.options import AS_JSON, PATH
from clew.verbs.say import warn
from protocol.errors import UsageError

FOLDER = "figures"
FORMATS = ("svg", "pdf", "png")


def _formats(_ctx: click.Context, _param: click.Parameter, said: str) -> tuple[str, ...]:
    formats = tuple(dict.fromkeys(each.strip() for each in said.split(",")))
    unknown = [each for each in formats if each not in FORMATS]
    if unknown:
        raise UsageError(f"--format {said}: {unknown[0]!r} is none of {', '.join(FORMATS)}")
    return formats


@click.command()
@click.argument("source", metavar="RUN|CAMPAIGN", type=PATH)
@click.option("--out", type=PATH, help="Folder for the figures; default: figures/ beside the log.")
@click.option(
    "--format",
    "formats",
    callback=_formats,
    default=",".join(FORMATS),
    show_default=True,
    help="Formats, separated by commas.",
)
@AS_JSON
def figures(source: Path, *, out: Path | None, formats: tuple[str, ...], as_json: bool) -> None:
    """Draw figures of a run or of a campaign, for print.

    The argument is a folder, an events.jsonl or a campaign.json. The verb prints the paths of the files. A
    figure that cannot be drawn is named on stderr; the others are drawn.
    """
    from clew.figures.source import read_source

    read = read_source(source)  # first: what cannot be drawn needs no library
    need("matplotlib", extra="plot", by="figures need")
    from clew.figures.draw import charts_of, write
    from clew.figures.style import LeftOut

    charts, flaws = charts_of(read)
    for flaw in flaws:
        warn(f"not complete: {flaw}")
    left_out = {each.name: each.why for each in charts if isinstance(each, LeftOut)}
    for name, why in left_out.items():
        warn(f"not drawn: {name}: {why}")
    folder = source if source.is_dir() else source.parent
    written = [str(path) for path in write(charts, out or folder / FOLDER, formats)]
    click.echo(json.dumps({"written": written, "left_out": left_out}) if as_json else "\n".join(written))
