"""`clew log cat`: prints the entries of a timeline, one a line; of a running fleet, as they come."""

import sys
from collections.abc import Callable
from contextlib import aclosing
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.options import AS_JSON, COLOR, FINITE, ROBOT, RUN
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.plain import plain
from protocol.process.streams import reader_has_gone
from protocol.timeline import Entry
from protocol.timeline.sentences import sentence

if TYPE_CHECKING:
    from clew.log.timeline import Choice

Say = Callable[[str, Entry], None]
AT_ONCE = 1000  # lines in one write, because each write is a system call


@click.command()
@RUN
@click.option("--source", multiple=True, help="Only entries by this source: world, r1, ...; repeatable.")
@click.option("--kind", multiple=True, help="Only entries of this kind, for example 'step.*'; repeatable.")
@click.option("--without", multiple=True, help="No entries of this kind, for example 'pose.*'; repeatable.")
@click.option("--robot", type=ROBOT, help="Only entries by this robot or about it, including faults.")
@click.option("--step", type=int, help="Only entries of this switching step of the leader.")
@click.option(
    "--rule", multiple=True, help="Only injections of this fault rule, for example 'kill-*'; repeatable."
)
@click.option(
    "--key",
    multiple=True,
    help="Only entries about messages on this key, for example 'link/r2/*'; repeatable.",
)
@click.option("--from", "from_s", type=FINITE, help="Only entries from this time on [simulated s].")
@click.option("--to", "to_s", type=FINITE, help="Only entries up to this time [simulated s].")
@click.option(
    "--follow", "following", is_flag=True, help="Wait for new entries until the run has ended or Ctrl-C."
)
@click.option("--fields", is_flag=True, help="Print the fields of each entry instead of a sentence.")
@COLOR
@AS_JSON
def cat(
    run: Path,
    *,
    as_json: bool,
    fields: bool,
    following: bool,
    color: str,
    without: tuple[str, ...],
    **choice: tuple[str, ...] | float | None,
) -> None:
    """Print the entries of a timeline, each as a sentence on a line.

    Options choose entries by source, kind, robot, step, fault rule, key of a message, and time. With
    --follow, the run may still be going on, or may not have started yet.
    """
    from clew.log.line import fields_of, is_coloured, one_line
    from clew.log.timeline import Choice, unknown_kinds
    from protocol.timeline import kind_of
    from world.record.recorder import line

    if (unknown := unknown_kinds(without)) is not None:
        raise UsageError(f"--without: {unknown}")
    chosen, coloured = msgspec.convert(choice, Choice), is_coloured(color) and not as_json
    printer = _Printer(1 if following or sys.stdout.isatty() else AT_ONCE, coloured=coloured)

    def say(source: str, entry: Entry) -> None:
        kind = kind_of(entry.record)
        if chosen.takes(source, entry) and not any(fnmatchcase(kind, pattern) for pattern in without):
            if as_json:
                printer.say(line(source, entry).decode().rstrip())
                return
            said = fields_of(entry.record) if fields else plain(sentence(source, entry.record))
            printer.say(one_line(source, entry, said, coloured=coloured))

    if following:
        import asyncio

        asyncio.run(_follow(run, say))
        flaws: tuple[str, ...] = ()  # warned of as they came
    else:
        flaws = _read(run, say)
    printer.flush()
    for flaw in flaws:
        _warn(flaw)
    if not printer.has_said:
        _refuse_unknown(run, chosen)
        warn("no entry matches")


class _Printer:
    """Prints lines one by one, or many in one write."""

    def __init__(self, at_once: int, *, coloured: bool) -> None:
        self.has_said = False
        self._at_once, self._coloured = at_once, coloured
        self._lines: list[str] = []

    def say(self, said: str) -> None:
        self.has_said = True
        self._lines.append(said)
        if len(self._lines) >= self._at_once:
            self.flush()

    def flush(self) -> None:
        if self._lines:
            click.echo("\n".join(self._lines), color=self._coloured)
            self._lines.clear()
            if reader_has_gone():  # a log is long, and with --follow it has no end
                raise click.exceptions.Exit(ExitCode.OK)


def _refuse_unknown(run: Path, choice: "Choice") -> None:
    """Raise `UsageError` where no entry matches because this run cannot have one of the names asked for."""
    from clew.log.log import Log
    from clew.log.timeline import unknown_in

    log = Log(run)
    unknown = unknown_in(choice, log.header, log.lines)
    if unknown is not None:
        raise UsageError(f"no entry matches; {unknown}")


def _read(run: Path, say: Say) -> tuple[str, ...]:
    from clew.log.log import Log

    read = Log(run)
    for source, entry in read.lines:
        say(source, entry)
    return read.flaws


async def _follow(run: Path, say: Say) -> None:
    from clew.log.follow import follow

    async with aclosing(follow(run)) as all_news:
        async for news in all_news:
            for source, entry in news.lines:
                say(source, entry)
            for flaw in news.flaws:
                _warn(flaw)


def _warn(flaw: str) -> None:
    warn(f"not complete: {flaw}")
