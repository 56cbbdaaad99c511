"""Prints for people and for programs. Text from a log or a file cannot control the terminal."""

import sys

import click
import msgspec
from rich.console import Console

from protocol.plain import plain

PIPE_COLUMNS = 140  # a table's width where stdout is no terminal


def say(line: str) -> None:
    """Print a line on stdout."""
    click.echo(plain(line))


def warn(line: str) -> None:
    """Print a line on stderr."""
    click.echo(plain(line), err=True)


def say_json(value: object) -> None:
    """Print a value as JSON with indents."""
    click.echo(msgspec.json.format(msgspec.json.encode(value)).decode())


def console() -> Console:
    """A console for tables on stdout."""
    return Console() if sys.stdout.isatty() else Console(width=PIPE_COLUMNS)
