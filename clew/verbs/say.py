"""Prints what may hold words of a log or of a file: a line each, which no terminal obeys."""

import click

from protocol.plain import plain


def say(line: str) -> None:
    """On stdout."""
    click.echo(plain(line))


def warn(line: str) -> None:
    """On stderr."""
    click.echo(plain(line), err=True)
