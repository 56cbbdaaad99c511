"""`clew log why`: which scan, which messages and which decisions led to an entry."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.options import AS_JSON, RUN
from clew.verbs.say import say, warn
from protocol.errors import UsageError

if TYPE_CHECKING:
    from clew.log.journals.links import Link


@click.command()
@RUN
@click.argument("entry")
@click.option(
    "--effects", is_flag=True, help="Also show what the entry's decision led to, message by message."
)
@AS_JSON
def why(run: Path, entry: str, *, effects: bool, as_json: bool) -> None:
    """Show the way to an entry: which scan, which messages and which decisions led to it, newest last.

    ENTRY is its source and number, as r3:17, a line that `clew log cat` printed, or a kind that only one
    entry has. The cause of a decision is found by replays: it is the newest input without which the robot's
    core would not have decided so. The fields of a message that mattered follow it in brackets.

    With --effects, the entry is followed by the messages of its decision, by what their receivers did at
    once, and so on.
    """
    from clew.log.journals.entries import find_entry
    from clew.log.journals.process import gaps, processes_of
    from clew.log.journals.why import Why
    from clew.log.log import Log

    log = Log(run)
    lines = list(log.lines)
    folder = log.path.parent
    index = find_entry(lines, entry)
    processes = processes_of(folder)
    missing = list(gaps(folder, processes))
    if not processes:
        raise UsageError(missing[0])
    for gap in missing:
        warn(f"not complete: {gap}")
    causes = Why(processes, lines)
    for link in [*causes.way(index), *(causes.effects(index) if effects else ())]:
        say(msgspec.json.encode(link.as_dict()).decode() if as_json else line_of(link))


def line_of(link: "Link") -> str:
    """One thing on the way, on one line."""
    return f"{link.t_s:9.3f} {link.source:>6} {link.what:<9} {link.said}"
