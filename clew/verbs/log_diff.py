"""`clew log diff`: finds the first difference of two runs."""

import re
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec

from clew.verbs.options import AS_JSON, COLOR, PATH, FiniteRange, Word
from clew.verbs.say import warn
from protocol.plain import plain
from world.record.lines import Line

if TYPE_CHECKING:
    from clew.log.diff import Difference
    from clew.log.log import Log

FIELDS_SHOWN = 8  # all 360 rays of a scan may differ


@click.command()
@click.argument("a", type=PATH)
@click.argument("b", type=PATH)
@click.option(
    "--by",
    type=Word(["entry", "step"]),
    default="entry",
    show_default=True,
    help="step: compare only the leader's steps and their results, at any time; for live runs.",
)
@click.option(
    "--within",
    type=FiniteRange(0.0),
    default=0.0,
    show_default=True,
    help="How much numbers may differ.",
)
@COLOR
@AS_JSON
@click.pass_context
def diff(ctx: click.Context, a: Path, b: Path, *, by: str, within: float, color: str, as_json: bool) -> None:
    """Show the first difference of two runs, A and B.

    Two rehearsals with one seed are the same. Clocks, process ids and names of runs are ignored. Exits with 1
    when the runs differ.
    """
    from clew.log.diff import headers_apart
    from clew.log.line import is_coloured
    from clew.log.log import Log
    from clew.rehearsal.recorded import EPOCH

    ours, theirs = Log(a), Log(b)
    asked = headers_apart(ours.header, theirs.header)
    found = _found(ours, theirs, by_step=by == "step", within=within)
    unread = ours.unread != theirs.unread
    same = found is None and not asked and not unread
    flaws = {"a": ours.flaws, "b": theirs.flaws}
    if as_json:
        said = {"same": same, "header": asked, "unread": unread, "flaws": flaws, "difference": _raws(found)}
        click.echo(msgspec.json.encode(said).decode())
    else:
        coloured = is_coloured(color)
        if asked:
            click.echo(f"the runs were started differently: {_some(asked)}")
        if unread:
            click.echo("the unreadable lines differ")
        for sentence in _sentences(found, same=same, coloured=coloured):
            click.echo(sentence, color=coloured)
        started = (ours.header.started_at, theirs.header.started_at)
        if found is not None and by == "entry" and EPOCH not in started:
            click.echo("entries of two live runs always differ: use --by step", err=True)
    for which, each in flaws.items():
        for flaw in each:
            warn(f"{which} is not complete: {flaw}")
    ctx.exit(0 if same else 1)


def _found(ours: "Log", theirs: "Log", *, by_step: bool, within: float) -> "Difference | None":
    """The first difference. Both logs are read to the end, so that all their flaws are known."""
    from clew.log.diff import NO_DIFFERENCE, NO_DIFFERENCE_OF_STEPS, first_difference, steps_of

    a, b = ours.lines, theirs.lines
    if by_step:
        found = first_difference(steps_of(a), steps_of(b), but=NO_DIFFERENCE_OF_STEPS, within=within)
    else:
        found = first_difference(a, b, but=NO_DIFFERENCE, within=within)
    for rest in (a, b):
        deque(rest, maxlen=0)
    return found


def _sentences(found: "Difference | None", *, same: bool, coloured: bool) -> Iterator[str]:
    if found is None:
        yield "the same" if same else "no entry differs"
        return
    what = _some(found.fields) if found.a and found.b else "one run has ended"
    yield f"the first difference comes after {found.entry} equal entries: {what}"
    for each in found.before:
        yield f"  {_line(each, coloured=coloured)}"
    only = _shown(found)
    for sign, colour, here, after in (
        ("-", "red", found.a, found.after_a),
        ("+", "green", found.b, found.after_b),
    ):
        for each in [] if here is None else [here, *after]:
            mark = click.style(sign, fg=colour) if coloured else sign
            yield f"{mark} {_line(each, coloured=coloured, only=only if each is here else None)}"


def _shown(found: "Difference") -> frozenset[str] | None:
    """The fields that differ, without what is inside them; None: all, of entries of two kinds."""
    names = frozenset(re.split(r"[.\[]", name)[0] for name in found.fields)
    return None if not names or "kind" in names else names


def _line(line: Line, *, coloured: bool, only: frozenset[str] | None = None) -> str:
    from clew.log.line import fields_of, one_line

    source, entry = line
    return one_line(
        source, entry, fields_of(entry.record, exact=only is not None, only=only), coloured=coloured
    )


def _some(names: tuple[str, ...]) -> str:
    more = len(names) - FIELDS_SHOWN
    return plain(", ".join(names[:FIELDS_SHOWN])) + (f" and {more} more" if more > 0 else "")


def _raws(found: "Difference | None") -> dict[str, Any] | None:
    """A difference, with its entries as in the log."""
    if found is None:
        return None
    return {
        "entry": found.entry,
        "fields": found.fields,
        "a": _raw(found.a),
        "b": _raw(found.b),
        "before": [_raw(each) for each in found.before],
        "after_a": [_raw(each) for each in found.after_a],
        "after_b": [_raw(each) for each in found.after_b],
    }


def _raw(entry: Line | None) -> msgspec.Raw | None:
    """The line of the log."""
    from world.record.recorder import line

    return None if entry is None else msgspec.Raw(line(*entry).rstrip())
