"""`clew log diff`: where two runs part."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import click
import msgspec

from lab.log import Log
from lab.log_diff import (
    NO_DIFFERENCE,
    NO_DIFFERENCE_OF_STEPS,
    Difference,
    first_difference,
    headers_apart,
    steps_of,
)
from lab.log_line import WHEN, is_coloured, one_line
from lab.options import AS_JSON
from lab.plain import plain
from lab.rehearse import EPOCH
from world.lines import Line
from world.recorder import line

FIELDS_SHOWN = 8  # of a scan, 360 rays may differ
PATH = click.Path(path_type=Path)


@click.command()
@click.argument("a", type=PATH)
@click.argument("b", type=PATH)
@click.option(
    "--by",
    type=click.Choice(["entry", "step"]),
    default="entry",
    show_default=True,
    help="step: only what the leader planned and what came of it, whenever that was; for live runs.",
)
@click.option(
    "--within",
    type=click.FloatRange(0.0),
    default=0.0,
    show_default=True,
    help="Numbers may differ by so much.",
)
@WHEN
@AS_JSON
@click.pass_context
def diff(ctx: click.Context, a: Path, b: Path, *, by: str, within: float, color: str, as_json: bool) -> None:
    """Show the first difference of two runs, A and B: of two rehearsals of one seed there is none.

    Clocks, process ids and names of runs are no difference. Exit code: 0 the same, 1 different.
    """
    ours, theirs = Log(a), Log(b)
    asked = headers_apart(ours.header, theirs.header)
    if by == "step":
        but = NO_DIFFERENCE_OF_STEPS
        found = first_difference(steps_of(ours.lines), steps_of(theirs.lines), but=but, within=within)
    else:
        found = first_difference(ours.lines, theirs.lines, but=NO_DIFFERENCE, within=within)
    if as_json:
        click.echo(msgspec.json.encode(_as_json(asked, found)).decode())
    else:
        coloured = is_coloured(color)
        for said in _sentences(asked, found, coloured=coloured):
            click.echo(said, color=coloured)
        started = (ours.header.started_at, theirs.header.started_at)
        if found is not None and by == "entry" and EPOCH not in started:
            click.echo("entries of two live runs always differ: --by step says what came of them", err=True)
    if found is None:
        for flaw in chain(ours.flaws, theirs.flaws):
            click.echo(f"not complete: {flaw}", err=True)
    ctx.exit(0 if found is None and not asked else 1)


def _sentences(asked: tuple[str, ...], found: Difference | None, *, coloured: bool) -> Iterator[str]:
    if asked:
        yield f"asked for different runs: {_some(asked)}"
    if found is None:
        yield "no entry differs" if asked else "the same"
        return
    what = _some(found.fields) if found.a and found.b else "one has ended"
    yield f"the first difference is behind {found.entry} entries in common: {what}"
    for each in found.before:
        yield "  " + one_line(*each, coloured=coloured, exact=True)
    for sign, colour, here, after in (
        ("-", "red", found.a, found.after_a),
        ("+", "green", found.b, found.after_b),
    ):
        for each in [] if here is None else [here, *after]:
            mark = click.style(sign, fg=colour) if coloured else sign
            yield f"{mark} {one_line(*each, coloured=coloured, exact=True)}"


def _some(names: tuple[str, ...]) -> str:
    more = len(names) - FIELDS_SHOWN
    return plain(", ".join(names[:FIELDS_SHOWN])) + (f" and {more} more" if more > 0 else "")


def _as_json(asked: tuple[str, ...], found: Difference | None) -> dict[str, Any]:
    said: dict[str, Any] = {"same": found is None and not asked, "header": asked, "difference": None}
    if found is not None:
        said["difference"] = {
            "entry": found.entry,
            "fields": found.fields,
            "a": _raw(found.a),
            "b": _raw(found.b),
            "before": [_raw(each) for each in found.before],
            "after_a": [_raw(each) for each in found.after_a],
            "after_b": [_raw(each) for each in found.after_b],
        }
    return said


def _raw(entry: Line | None) -> msgspec.Raw | None:
    """As the log has it."""
    return None if entry is None else msgspec.Raw(line(*entry).rstrip())
