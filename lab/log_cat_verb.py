"""`clew log cat`: the entries of a timeline, one a line; of a run that goes on, as they come."""

import asyncio
import os
import sys
from collections.abc import Callable
from contextlib import aclosing
from fnmatch import fnmatchcase
from pathlib import Path

import click
import msgspec

from lab.follow import follow
from lab.log import Log
from lab.log_line import WHEN, is_coloured, one_line
from lab.log_verbs import RUN
from lab.options import AS_JSON
from lab.timeline import Choice, kind_of
from protocol.timeline import Entry
from world.recorder import line

Say = Callable[[str, Entry], None]


@click.command()
@RUN
@click.option("--source", multiple=True, help="Only entries by this source: world, r1, ...; may be repeated.")
@click.option("--kind", multiple=True, help="Only this kind; 'step.*' works too; may be repeated.")
@click.option("--without", multiple=True, help="All but this kind, as 'pose.*'; may be repeated.")
@click.option("--robot", type=int, help="Only entries by this robot or about it.")
@click.option("--step", type=int, help="Only this switching step of the leader.")
@click.option("--from", "from_s", type=float, help="Only from this time on [simulated s].")
@click.option("--to", "to_s", type=float, help="Only up to this time [simulated s].")
@click.option(
    "--follow", "following", is_flag=True, help="Go on with what comes, until the run has ended or Ctrl-C."
)
@WHEN
@AS_JSON
def cat(
    run: Path,
    *,
    as_json: bool,
    following: bool,
    color: str,
    without: tuple[str, ...],
    **choice: tuple[str, ...] | float | None,
) -> None:
    """Print the entries of a timeline, all or those chosen, one a line.

    With --follow, RUN may still go on, or not even be there yet.
    """
    chosen, coloured = msgspec.convert(choice, Choice), is_coloured(color) and not as_json

    def say(source: str, entry: Entry) -> None:
        kind = kind_of(entry.record)
        if chosen.takes(source, entry) and not any(fnmatchcase(kind, pattern) for pattern in without):
            said = line(source, entry).decode().rstrip() if as_json else None
            click.echo(said or one_line(source, entry, coloured=coloured), color=coloured)

    try:
        if following:
            asyncio.run(_follow(run, say))
        else:
            _read(run, say)
    except BrokenPipeError:
        # Whoever reads has had enough, as `head` has; Python would complain when it flushes at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _read(run: Path, say: Say) -> None:
    read = Log(run)
    for source, entry in read.lines:
        say(source, entry)
    for flaw in read.flaws:
        _warn(flaw)


async def _follow(run: Path, say: Say) -> None:
    async with aclosing(follow(run)) as all_news:
        async for news in all_news:
            for heard in news.heard:
                say(heard.source, heard.entry)
            for flaw in news.flaws:
                _warn(flaw)


def _warn(flaw: str) -> None:
    click.echo(f"not complete: {flaw}", err=True)
