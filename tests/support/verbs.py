"""All verbs of the command line, for tests."""

from collections.abc import Iterator
from typing import Any

import click

Words = tuple[str, ...]


def commands(
    verb: click.Command, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """The verb and all verbs below it, with the words by which they are called."""
    yield path, verb
    if isinstance(verb, click.Group):
        above = context(verb, info_name=path[-1] if path else None, parent=_above(path))
        for name in verb.list_commands(above):
            below = verb.get_command(above, name)
            assert below is not None, name
            yield from commands(below, (*path, name))


def context(verb: click.Command, **more: Any) -> click.Context:  # noqa: ANN401 - click's own
    """A context with our options for help: click keeps those of the first context of a verb."""
    return click.Context(verb, help_option_names=["-h", "--help"], **more)


def _above(path: Words) -> click.Context | None:
    """A context with the words above the last."""
    above = context(click.Group()) if path else None
    for word in path[:-1]:
        above = context(click.Group(), info_name=word, parent=above)
    return above
