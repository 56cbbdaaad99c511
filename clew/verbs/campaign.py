"""`clew campaign`: many scenes, several seeds, a table by family."""

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import click
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from clew.campaign.campaign import CAMPAIGN_FILE, Campaign, Request, cores, run
from clew.campaign.classes import class_table, coverage_table
from clew.campaign.episode import SWARM
from clew.campaign.families import table
from clew.fleet.folder import RUNS
from clew.verbs.options import AS_JSON, DEPLOYMENT, LAW, robots_option
from clew.verbs.say import say
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.run_settings import SEED_MAX

Watch = Callable[[int, int, int], None]

PIPE_COLUMNS = 140  # the table's width where stdout is no terminal
REPORTS = 20  # lines of progress where stderr is no terminal: one for each 5 %


def _seeds(_ctx: click.Context, _param: click.Parameter, said: str) -> tuple[int, ...]:
    """The seeds that a text says, each once."""
    seeds: list[int] = []
    for part in said.split(","):
        match = re.fullmatch(r"(\d{1,16})(?:-(\d{1,16}))?", part, re.ASCII)
        if match is None or not int(match[1]) <= int(match[2] or match[1]) <= SEED_MAX:
            raise click.BadParameter(f"must be like 1, 1-3 or 1,4-6, up to 2**53 - 1, got {said}")
        seeds += range(int(match[1]), int(match[2] or match[1]) + 1)
    return tuple(dict.fromkeys(seeds))


@click.command()
@click.option(
    "--scenes",
    "roots",
    multiple=True,
    type=click.Path(path_type=Path),
    help="May be repeated.",
)
@click.argument("more", nargs=-1, type=click.Path(path_type=Path))
@robots_option("Robots, instead of each scenario's (of a scene: 5).")
@click.option("--seeds", callback=_seeds, default="1", show_default=True, help="Like 1, 1-3 or 1,4-6.")
@LAW
@DEPLOYMENT
@click.option(
    "--tight",
    type=click.FloatRange(0.0, 2.0, min_open=True),
    help="Give each scene a robot whose r + epsilon is this share of its widest path.",
)
@click.option(
    "--faults", metavar="PLAN|swarm", help="What goes wrong; swarm: each seed draws it, and its world."
)
@click.option("--keep", is_flag=True, help="Write down every drawn world and plan, not only what surprises.")
@click.option("--jobs", type=click.IntRange(1), help="Processes; 1: this one. Default: as many as cores.")
@click.option("--out", type=click.Path(path_type=Path), help="The campaign's folder; the same again goes on.")
@click.option(
    "--wall-s-max",
    type=click.FloatRange(0.0, min_open=True),
    default=300.0,
    show_default=True,
    help="Longest that an episode may take [s].",
)
@AS_JSON
@click.pass_context
def campaign(
    ctx: click.Context,
    roots: tuple[Path, ...],
    more: tuple[Path, ...],
    *,
    robots: int | None,
    seeds: tuple[int, ...],
    law: str | None,
    deployment: str | None,
    tight: float | None,
    faults: str | None,
    keep: bool,
    jobs: int | None,
    out: Path | None,
    wall_s_max: float,
    as_json: bool,
) -> None:
    """Rehearse every scene below --scenes DIR... with every seed; say what surprises, family by family.

    With --faults swarm each seed draws a small world of its own and what goes wrong in it.

    Exit code: 0 no surprise, 1 a surprise, 2 it cannot be done as asked, 130 interrupted.
    """
    _check(bool(roots), faults, (robots, law, deployment, tight))
    request = Request(
        roots=(*roots, *more),
        robots=robots,
        seeds=seeds,
        law=law,
        deployment=deployment,
        tight=tight,
        faults=faults,
        keep=keep,
        jobs=jobs or cores(),
        out=out or RUNS / f"campaign-{datetime.now(UTC):%Y%m%dT%H%M%SZ}",
        wall_s_max=wall_s_max,
    )
    with _watching() as watch:
        result = run(request, watch)
    if as_json:
        click.echo((request.out / CAMPAIGN_FILE).read_text(encoding="utf-8"), nl=False)
    else:
        _print(result, request.out)
    ctx.exit(ExitCode.INTERRUPTED if result.interrupted else 0 if result.ok else ExitCode.FAILED)


def _check(has_scenes: bool, faults: str | None, of_scenes: tuple[object, ...]) -> None:
    """Refuse options that do not go together.

    Raises:
        UsageError: it names them.
    """
    if faults != SWARM:
        if not has_scenes:
            raise UsageError("--scenes: must be there, but with --faults swarm, which draws its own")
        return
    if has_scenes or any(each is not None for each in of_scenes):
        raise UsageError(
            "--faults swarm: each seed draws its own world, so there must be none of"
            " --scenes, --robots, --law, --deployment and --tight"
        )


def _print(result: Campaign, out: Path) -> None:
    console = Console() if sys.stdout.isatty() else Console(width=PIPE_COLUMNS)
    console.print(table(result.families, result.all))
    if result.faults == SWARM:
        console.print(class_table(result.classes))
        console.print(coverage_table(result.coverage))
    for outcome in result.surprises:
        say(f"{outcome.surprise}: {outcome.family}/{outcome.scene}, seed {outcome.seed}: {outcome.reason}")
        say(f"    {outcome.replay}")
    if result.uncovered:
        say(f"not covered: {', '.join(result.uncovered)}")
    word = "INTERRUPTED" if result.interrupted else "OK" if result.ok else "FAILED"
    done, asked = result.all.episodes, result.episodes_asked
    click.echo(f"{word}: {done} of {asked} episodes, {len(result.surprises)} surprises. Campaign: {out}")


@contextmanager
def _watching() -> Iterator[Watch]:
    """Who is told of the progress: a bar on a terminal, else a line now and then."""
    if not sys.stderr.isatty():
        yield _report
        return
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeElapsedColumn())
    remaining = (TimeRemainingColumn(), TextColumn("{task.fields[surprises]} surprises"))
    with Progress(*columns, *remaining, console=Console(stderr=True)) as progress:
        task = progress.add_task("episodes", total=None, surprises=0)
        yield lambda done, asked, surprises: progress.update(
            task, completed=done, total=asked, surprises=surprises
        )


def _report(done: int, asked: int, surprises: int) -> None:
    if done == asked or done * REPORTS // asked > (done - 1) * REPORTS // asked:
        click.echo(f"{done} of {asked} episodes, {surprises} surprises", err=True)
