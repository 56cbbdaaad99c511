"""`clew ls`: lists runs, and deletes them."""

from datetime import UTC, datetime
from pathlib import Path

import click

from clew.fleet.folder import RUNS
from clew.fleet.runs import Listed, check_is_run, deletable, delete, listed, runs_in
from clew.verbs.options import AS_JSON, PATH
from clew.verbs.say import console, say_json, warn
from protocol.errors import UsageError
from protocol.plain import plain

UNITS = (("d", 86400.0), ("h", 3600.0), ("min", 60.0), ("s", 1.0))


@click.command()
@click.argument("runs", metavar="[RUN]...", nargs=-1, type=PATH)
@click.option("--delete", "is_deleting", is_flag=True, help="Delete these runs, after a question.")
@click.option("--yes", is_flag=True, help="With --delete: do not ask.")
@AS_JSON
def ls(runs: tuple[Path, ...], *, is_deleting: bool, yes: bool, as_json: bool) -> None:
    """List runs with their verdicts, sizes and ages, the newest first.

    RUN is the folder of a run; without one, all runs in runs/ are listed. The age is the time since the run
    was last written to. A run that is going on is not deleted; then nothing is.
    """
    now_s = datetime.now(UTC).timestamp()
    if is_deleting:
        _delete(runs, now_s, yes=yes)
        return
    if yes:
        raise UsageError("--yes: is for --delete")
    for run in runs:
        check_is_run(run)
    found = [listed(run, now_s) for run in runs] if runs else runs_in(RUNS, now_s)
    if as_json:
        say_json(found)
    elif found:
        _print(found)
    else:
        warn(f"no run in {RUNS}/")


def _delete(runs: tuple[Path, ...], now_s: float, *, yes: bool) -> None:
    if not runs:
        raise UsageError("--delete: name the runs to delete; runs/* are all of them")
    found = list(deletable(runs, now_s))
    if not yes:
        _print(found)
        what = "this run" if len(found) == 1 else f"these {len(found)} runs"
        size = _size(sum(each.size_bytes for each in found))
        click.confirm(f"Delete {what}, {size}?", abort=True, err=True)
    for each in found:
        delete(each)


def _print(found: list[Listed]) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table("run", "verdict", "size", "age", box=None)
    for column in table.columns[2:]:
        column.justify, column.no_wrap = "right", True
    for each in found:
        table.add_row(Text(plain(each.run)), Text(plain(each.said)), _size(each.size_bytes), _age(each.age_s))
    console().print(table)


def _size(size_bytes: int) -> str:
    return f"{size_bytes / 1e6:.1f} MB"


def _age(age_s: float) -> str:
    unit, length_s = next(((unit, length_s) for unit, length_s in UNITS if age_s >= length_s), UNITS[-1])
    return f"{age_s / length_s:.0f} {unit}"
