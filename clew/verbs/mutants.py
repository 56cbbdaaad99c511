"""`clew mutants`: plants bugs in copies of the source, which a swarm campaign must catch."""

import click
from rich.table import Table

from clew.campaign.mutants import Caught, run_mutant
from clew.campaign.mutants_list import MUTANTS
from clew.verbs.options import AS_JSON
from clew.verbs.say import console, say_json
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode


@click.command()
@click.option("--mutant", "names", multiple=True, metavar="NAME", help="Only this mutant; repeatable.")
@AS_JSON
@click.pass_context
def mutants(ctx: click.Context, names: tuple[str, ...], *, as_json: bool) -> None:
    """Check that a swarm campaign catches bugs that are planted on purpose (mutation testing).

    Each mutant is a copy of our source with one bug. Exits with 1 when a mutant was not caught within its
    number of seeds.
    """
    if unknown := sorted(set(names) - {mutant.name for mutant in MUTANTS}):
        raise UsageError(
            f"--mutant {unknown[0]}: must be one of {', '.join(mutant.name for mutant in MUTANTS)}"
        )
    caught: list[Caught] = []
    for mutant in MUTANTS:
        if not names or mutant.name in names:
            caught.append(run_mutant(mutant))
            click.echo(f"mutants: {_sentence(caught[-1])}", err=True)
    if as_json:
        say_json(caught)
    else:
        console().print(_table(caught))
    ctx.exit(ExitCode.OK if all(each.ok for each in caught) else ExitCode.FAILED)


def _sentence(caught: Caught) -> str:
    if caught.by is None:
        return f"{caught.mutant} was NOT caught in {caught.seeds} seeds"
    return f"{caught.mutant} was caught by {caught.by} in seed {caught.seed}"


def _table(caught: list[Caught]) -> Table:
    rules = {mutant.name: mutant.rule for mutant in MUTANTS}
    drawn = Table("mutant", "rule that it breaks", "caught by", "after seeds", "of", "CPU, s")
    for column in drawn.columns[3:]:
        column.justify = "right"
    for each in caught:
        drawn.add_row(
            each.mutant,
            rules[each.mutant],
            each.by or "NOT CAUGHT",
            str(each.seeds),
            str(each.seeds_max),
            f"{each.cpu_s:.1f}",
        )
    return drawn
