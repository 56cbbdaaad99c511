"""`clew schema`: prints the JSON Schema of scenario files or of fault plans."""

import click

from clew.verbs.options import Word


@click.command()
@click.argument("what", type=Word(["scenario", "faults"]), default="scenario")
def schema(what: str) -> None:
    """Print the JSON Schema of scenario files or of fault plans, for editors."""
    from clew.manual.parts import schema_line

    click.echo(schema_line(what), nl=False)
