"""Groups of verbs: each verb is imported when it is called, and its help ends with examples.

Rule 1: help and completion of a group import none of its verbs.
Rule 2: a verb's help ends with its examples, from one table.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import click
from click.shell_completion import CompletionItem

from clew.verbs.examples import EXAMPLES


@dataclass(frozen=True, slots=True)
class Late:
    """A verb that is imported when it is called."""

    place: str
    """Its module in `clew.verbs` and its name there, as `log_cat:cat`."""
    about: str
    """What it does, for the list of verbs."""

    def load(self) -> click.Command:
        """The verb."""
        module, _, name = self.place.partition(":")
        verb = getattr(import_module(f"clew.verbs.{module}"), name)
        assert isinstance(verb, click.Command), self.place
        return verb


class LateGroup(click.Group):
    """A group whose verbs are imported when they are called; others are added as usual."""

    def __init__(self, *, late: Mapping[str, Late] | None = None, **more: Any) -> None:  # noqa: ANN401 - click's own
        super().__init__(**more)
        self.late = late or {}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of all verbs."""
        return sorted({*super().list_commands(ctx), *self.late})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The verb of this name, with its examples (rule 2)."""
        late = self.late.get(cmd_name)
        verb = super().get_command(ctx, cmd_name) if late is None else late.load()
        if verb is not None and verb.epilog is None:
            verb.epilog = examples((*words(ctx), cmd_name))
        return verb

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The verb that is called; the refusal of a mistyped one names the nearest of all."""
        try:
            return super().resolve_command(ctx, args)
        except click.exceptions.NoSuchCommand as error:
            names = self.list_commands(ctx)
            raise click.exceptions.NoSuchCommand(error.command_name, possibilities=names, ctx=ctx) from error

    def about(self, ctx: click.Context, name: str) -> str:
        """What a verb does, in a sentence."""
        if name in self.late:
            return self.late[name].about
        verb = super().get_command(ctx, name)
        return "" if verb is None else verb.get_short_help_str(limit=100)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The list of verbs in the help (rule 1)."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, self.about(ctx, name)) for name in self.list_commands(ctx)])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """The verbs and options that begin so (rule 1)."""
        found = [name for name in self.list_commands(ctx) if name.startswith(incomplete)]
        verbs = [CompletionItem(name, help=self.about(ctx, name)) for name in found]
        return verbs + click.Command.shell_complete(self, ctx, incomplete)


def words(ctx: click.Context) -> tuple[str, ...]:
    """The words that call the verb of a context, without the program's name."""
    if ctx.parent is None:
        return ()
    return (*words(ctx.parent), str(ctx.info_name))


def examples(path: tuple[str, ...]) -> str | None:
    """The end of the help of a verb."""
    lines = EXAMPLES.get(" ".join(path))
    return None if lines is None else "\b\nExamples:\n" + "\n".join(f"  clew {line}" for line in lines)
