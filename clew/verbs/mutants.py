"""`clew mutants`: plants bugs in copies of the source, which a swarm campaign must catch."""

from typing import TYPE_CHECKING

import click

from clew.verbs.options import AS_JSON, FiniteRange
from clew.verbs.say import console, numbers_table, say_json
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.files.names import did_you_mean
from protocol.files.refusals import short

if TYPE_CHECKING:
    from rich.table import Table

    from clew.mutants.guided import Compared, Comparison
    from clew.mutants.mutant import Mutant
    from clew.mutants.run import Caught


@click.command()
@click.option("--mutant", "names", multiple=True, metavar="NAME", help="Only this mutant; repeatable.")
@click.option("--guided", is_flag=True, help="Search for each mutant guided and uniform, and compare.")
@click.option(
    "--trials",
    type=click.IntRange(1, 99),
    default=5,
    show_default=True,
    help="With --guided: how often to search for each mutant, from different seeds on.",
)
@click.option(
    "--cpu-s-max",
    type=FiniteRange(min=0.0, min_open=True),
    default=120.0,
    show_default=True,
    help="With --guided: CPU seconds after which a trial gives up.",
)
@AS_JSON
@click.pass_context
def mutants(
    ctx: click.Context,
    names: tuple[str, ...],
    *,
    guided: bool,
    trials: int,
    cpu_s_max: float,
    as_json: bool,
) -> None:
    """Check that a swarm campaign catches bugs that are planted on purpose (mutation testing).

    Each mutant is a copy of our source with one bug. Exits with 1 when a mutant was not caught within its
    number of seeds.
    """
    from clew.mutants.list import MUTANTS
    from clew.mutants.run import run_mutant

    if unknown := sorted(set(names) - {mutant.name for mutant in MUTANTS}):
        known = [mutant.name for mutant in MUTANTS]
        near = did_you_mean(unknown[0], known)
        raise UsageError(f"--mutant: must be one of {', '.join(known)}, got {short(unknown[0])}{near}")
    if guided:
        if tested := [each.name for each in MUTANTS if each.check and each.name in names]:
            raise UsageError(f"--mutant {tested[0]}: a test catches it and no seed, so not for --guided")
        chosen = [each for each in MUTANTS if not each.check and (not names or each.name in names)]
        comparison = _compare(chosen, trials, cpu_s_max)
        if as_json:
            say_json(comparison)
        else:
            console().print(_comparison_table(comparison))
        ctx.exit(ExitCode.OK if all(each.guided.caught for each in comparison.mutants) else ExitCode.FAILED)
    caught: list[Caught] = []
    for mutant in MUTANTS:
        if not names or mutant.name in names:
            caught.append(run_mutant(mutant))
            click.echo(f"mutants: {_sentence(caught[-1])}; {caught[-1].cpu_s:.1f} CPU s", err=True)
    if as_json:
        say_json(caught)
    else:
        console().print(_table(caught))
    ctx.exit(ExitCode.OK if all(each.ok for each in caught) else ExitCode.FAILED)


def _compare(chosen: "list[Mutant]", trials: int, cpu_s_max: float) -> "Comparison":
    from clew.mutants.guided import compare, summed_up

    compared: list[Compared] = []
    for mutant in chosen:
        compared.append(each := compare(mutant, trials, cpu_s_max))
        ours, theirs = _figure(each.guided.seeds_median), _figure(each.uniform.seeds_median)
        click.echo(f"mutants: {mutant.name}: seeds until caught: {ours} guided, {theirs} uniform", err=True)
    return summed_up(compared)


def _comparison_table(comparison: "Comparison") -> "Table":
    """The medians of all mutants, guided and uniform."""
    columns = ("seeds", "uniform", "times", "CPU, s", "uniform", "times", "caught")
    drawn = numbers_table("mutant", *columns, left=("mutant",))
    for each in comparison.mutants:
        guided, uniform = each.guided, each.uniform
        drawn.add_row(
            each.mutant,
            _figure(guided.seeds_median),
            _figure(uniform.seeds_median),
            _least(each, each.seeds_ratio),
            _figure(guided.cpu_s_median, 1),
            _figure(uniform.cpu_s_median, 1),
            _least(each, each.cpu_ratio),
            f"{guided.caught}, {uniform.caught} of {len(guided.trials)}",
        )
    for name, seeds, cpu in (
        ("median", comparison.seeds_ratio_median, comparison.cpu_ratio_median),
        ("hard ones", comparison.seeds_ratio_median_hard, comparison.cpu_ratio_median_hard),
    ):
        drawn.add_row(name, "", "", _figure(seeds, 1), "", "", _figure(cpu, 1), "")
    return drawn


def _least(compared: "Compared", ratio: float | None) -> str:
    """A ratio, and that it may be more."""
    is_least = ratio is not None and compared.uniform.cpu_s_median is None
    return f"{'at least ' if is_least else ''}{_figure(ratio, 1)}"


def _figure(figure: float | None, decimals: int = 0) -> str:
    return "-" if figure is None else f"{figure:.{decimals}f}"


def _sentence(caught: "Caught") -> str:
    if caught.by is None:
        return f"{caught.mutant} was NOT caught in {caught.seeds} seeds"
    if caught.seed is None:
        return f"{caught.mutant} was caught by {caught.reason}"
    return f"{caught.mutant} was caught by {caught.by} in seed {caught.seed}"


def _table(results: "list[Caught]") -> "Table":
    from clew.mutants.list import MUTANTS

    rules = {mutant.name: mutant.rule for mutant in MUTANTS}
    words = ("mutant", "rule that it breaks", "caught by")
    drawn = numbers_table(*words, "after seeds", "of", "CPU, s", left=words)
    for each in results:
        drawn.add_row(
            each.mutant,
            rules[each.mutant],
            each.by or "NOT CAUGHT",
            str(each.seeds),
            str(each.seeds_max),
            f"{each.cpu_s:.1f}",
        )
    caught = sum(each.ok for each in results)
    seeds, cpu_s = sum(each.seeds for each in results), sum(each.cpu_s for each in results)
    drawn.add_row("all", "", f"{caught} of {len(results)}", str(seeds), "", f"{cpu_s:.1f}")
    return drawn
