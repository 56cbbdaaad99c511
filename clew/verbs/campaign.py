"""`clew campaign`: rehearses many scenes with several seeds, and prints a table by family."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.fleet.folder import RUNS
from clew.verbs.extras import need
from clew.verbs.options import AS_JSON, DEPLOYMENT, LAW, PATH, TIME, FiniteRange, robots_option, seeds_option
from clew.verbs.say import console, say, to_copy, warn
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.process.asked import terminable

if TYPE_CHECKING:
    from clew.campaign.campaign import Campaign, Source, Watch

JUDGE_EVERY = 100  # costs a thousandth of a campaign
SURPRISES_SHOWN = 20  # with two lines each, still less than most terminals keep
REPORTS = 20  # lines of progress if stderr is no terminal: one for each 5 %


@click.command()
@click.option(
    "--scenes",
    "roots",
    multiple=True,
    type=PATH,
    help="Folder or file with scenes, or a scenario's name; repeatable.",
)
@click.argument("more", metavar="[SCENES]...", nargs=-1, type=PATH)
@robots_option("Number of robots, instead of each scenario's; a scene has 5 by default.")
@seeds_option("Seeds, as 1, 1-3 or 1,4-6.")
@LAW
@DEPLOYMENT
@TIME
@click.option(
    "--tight",
    type=FiniteRange(0.0, 2.0, min_open=True),
    help="Give each scene a robot whose r + epsilon is this share of the scene's widest path.",
)
@click.option(
    "--faults",
    metavar="PLAN|drawn|swarm",
    help="Fault plan; drawn: each seed draws its own faults; swarm: also its own world.",
)
@click.option(
    "--guided", is_flag=True, help="With swarm: strike a robot of each seed wherever a new view begins."
)
@click.option(
    "--future",
    metavar="BRANCHES",
    help="With swarm: play one future of each seed, such as 3.101:r4:2,7.401:r1:1.",
)
@click.option(
    "--keep",
    is_flag=True,
    help="With swarm: write every drawn world and plan, not only those with a surprise.",
)
@click.option(
    "--jobs",
    type=click.IntRange(1),
    help="Number of worker processes; 1: play in this process. Default: one for each core.",
)
@click.option(
    "--executor",
    type=click.Choice(["processes", "dask"]),
    default="processes",
    show_default=True,
    help="What plays the episodes: processes of this machine, or the workers of a Dask cluster.",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Scheduler of the Dask cluster, such as tcp://127.0.0.1:8786."
)
@click.option(
    "--out",
    type=PATH,
    help="Folder of the campaign; an unfinished campaign there is continued. Default: a new one in runs/.",
)
@click.option(
    "--wall-s-max",
    type=FiniteRange(0.0, min_open=True),
    default=300.0,
    show_default=True,
    help="Limit for one episode [wall-clock s].",
)
@click.option(
    "--judge-every",
    type=click.IntRange(0),
    default=JUDGE_EVERY,
    show_default=True,
    help="Judge the first of every N episodes a second time (clew judge); 0: none.",
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
    time_s_max: float | None,
    tight: float | None,
    faults: str | None,
    guided: bool,
    future: str | None,
    keep: bool,
    jobs: int | None,
    executor: str,
    scheduler: str | None,
    out: Path | None,
    wall_s_max: float,
    judge_every: int,
    as_json: bool,
) -> None:
    """Rehearse every scene with every seed, and report surprises by family.

    A surprise is an outcome that a fleet without bugs never has, such as a broken promise. With --faults
    swarm, each seed draws its own small world and the faults in it. Exits with 1 when there was a surprise,
    or when a swarm of 2000 episodes or more leaves a coverage counter at 0.
    """
    from clew.campaign.campaign import CAMPAIGN_FILE, Request, cores, run
    from clew.campaign.executors.cluster import ClusterLostError

    _check(bool(roots or more), faults, (robots, law, deployment, time_s_max, tight))
    _check_swarm(faults, guided=guided, future=future, keep=keep)
    source = _source(executor, scheduler, jobs)
    request = Request(
        roots=(*roots, *more),
        robots=robots,
        seeds=seeds,
        law=law,
        deployment=deployment,
        time_s_max=time_s_max,
        tight=tight,
        faults=faults,
        guided=guided,
        future=future,
        keep=keep,
        jobs=jobs or cores(),
        out=out or RUNS / f"campaign-{datetime.now(UTC):%Y%m%dT%H%M%SZ}",
        wall_s_max=wall_s_max,
        judge_every=judge_every,
    )
    with terminable() as asked, _watching() as watch:
        try:
            result = run(request, watch, source, warn)
        except ClusterLostError as error:
            raise click.ClickException(str(error)) from error
    if as_json:
        click.echo((request.out / CAMPAIGN_FILE).read_text(encoding="utf-8"), nl=False)
    else:
        _print(result, request.out)
    ctx.exit(asked[0] if result.interrupted else 0 if result.ok else ExitCode.FAILED)


def _check(has_scenes: bool, faults: str | None, of_scenes: tuple[object, ...]) -> None:
    """Refuse options that exclude each other.

    Raises:
        UsageError: it names the options.
    """
    from clew.campaign.episode import SWARM

    if faults != SWARM:
        if not has_scenes:
            raise UsageError("SCENES: must be given, a folder or a file, unless --faults is swarm")
        return
    if has_scenes or any(each is not None for each in of_scenes):
        raise UsageError(
            "--faults swarm: each seed draws its own world, so --scenes, --robots, --law, --deployment,"
            " --time-s-max and --tight must not be given"
        )


def _check_swarm(faults: str | None, *, guided: bool, future: str | None, keep: bool) -> None:
    """Refuse futures, and drawn worlds, of anything but a swarm.

    Raises:
        UsageError: it names the option.
    """
    from clew.campaign.episode import SWARM
    from clew.swarm.futures import read_branches

    if faults != SWARM and (guided or keep or future is not None):
        raise UsageError("--guided, --future, --keep: need --faults swarm")
    if guided and future is not None:
        raise UsageError("--guided: makes its own futures, so --future must not be given")
    if future is not None:
        read_branches(future)


def _source(executor: str, scheduler: str | None, jobs: int | None) -> "Source":
    """What plays the episodes.

    Raises:
        UsageError: options exclude each other, or Dask is not installed.
    """
    from clew.campaign.campaign import hash_of_source
    from clew.campaign.executors.cluster import cluster_outcomes
    from clew.campaign.executors.pool import outcomes_of

    if executor == "processes":
        if scheduler is not None:
            raise UsageError("--scheduler: needs --executor dask")
        return outcomes_of
    if scheduler is None or jobs is not None:
        raise UsageError("--executor dask: needs --scheduler, and --jobs must not be given")
    need("distributed", extra="cluster", by="--executor dask needs")
    return partial(cluster_outcomes, scheduler=scheduler, source_hash=hash_of_source())


def _print(result: "Campaign", out: Path) -> None:
    from clew.campaign.classes import class_table, coverage_table
    from clew.campaign.episode import SWARM
    from clew.campaign.families import in_words, table
    from clew.swarm.futures import read_branches

    out_table = console()
    out_table.print(table(result.families, result.all))
    if result.faults == SWARM:
        out_table.print(class_table(result.classes))
        out_table.print(coverage_table(result.coverage))
    _print_surprises(result, out)
    if result.guided:
        strikes = sum(len(read_branches(each.branches)) for each in result.episodes)
        say(f"guided: {strikes} strikes")
    if result.uncovered:
        say(f"not covered: {', '.join(result.uncovered)}")
    word = "INTERRUPTED" if result.interrupted else "OK" if result.ok else "FAILED"
    left = result.episodes_asked - result.all.episodes
    more = f"; surprises: {len(result.surprises)}" if result.surprises else ""
    more += f"; not played: {left}" if left else ""
    click.echo(f"{word}: {in_words(result.episodes)}{more}. Campaign: {out}")


def _print_surprises(result: "Campaign", out: Path) -> None:
    """The first ones, each with its replay: many would hide the table above them."""
    from clew.campaign.campaign import CAMPAIGN_FILE

    for outcome in result.surprises[:SURPRISES_SHOWN]:
        say(f"{outcome.surprise}: {outcome.family}/{outcome.scene}, seed {outcome.seed}: {outcome.reason}")
        say(f"    {to_copy(outcome.replay)}")
    if (unshown := len(result.surprises) - SURPRISES_SHOWN) > 0:
        say(f"and {unshown} more surprises: `surprises` in {out / CAMPAIGN_FILE} has all")


@contextmanager
def _watching() -> "Iterator[Watch]":
    """Shows the progress: a bar on a terminal, otherwise a line for each 5 %."""
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

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
