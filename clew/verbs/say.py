"""Prints for people and for programs. Text from a log or a file cannot control the terminal."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from protocol.plain import plain
from protocol.root import IS_CHECKOUT, ROOT

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

PIPE_COLUMNS = 140  # a table's width where stdout is no terminal


def say(line: str) -> None:
    """Print a line on stdout."""
    click.echo(plain(line))


def warn(line: str) -> None:
    """Print a line on stderr."""
    click.echo(plain(line), err=True)


def many(count: int, what: str) -> str:
    """A count with its noun, as `1 run` or `2 runs`."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def to_copy(line: str) -> str:
    """A command line of the project's folder, with the program as a shell in the present folder finds it."""
    program, _, rest = line.partition(" ")
    if not IS_CHECKOUT:
        return f"{'clew' if program.endswith('/clew') else 'clew run'} {rest}"
    return line if Path.cwd() == ROOT else f"{shlex.quote(str(ROOT / program))} {rest}"


def say_json(value: object) -> None:
    """Print a value as JSON with indents."""
    click.echo(msgspec.json.format(msgspec.json.encode(value)).decode())


def console() -> "Console":
    """A console for tables on stdout."""
    from rich.console import Console

    return Console() if sys.stdout.isatty() else Console(width=PIPE_COLUMNS)


def numbers_table(*columns: str, left: tuple[str, ...] = (), title: str | None = None) -> "Table":
    """A table of numbers; `left`: the columns that hold words."""
    from rich.table import Column, Table

    return Table(
        *(Column(each, justify="left" if each in left else "right") for each in columns), title=title
    )
