"""`clew log`: reads and judges timelines."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.group import Late, LateGroup
from clew.verbs.options import AS_JSON, RUN
from protocol.plain import plain

if TYPE_CHECKING:
    from rich.text import Text

    from clew.log.summary import Judged, Summary


@click.group(
    cls=LateGroup,
    late={
        "cat": Late("log_cat:cat", "Print the entries of a timeline as sentences."),
        "diff": Late("log_diff:diff", "Show the first difference of two runs."),
        "messages": Late("log_messages:messages", "Print the messages that were received or lost."),
        "why": Late("log_why:why", "Show which scan, messages and decisions led to an entry."),
        "export": Late("log_export:export", "Export a timeline as MCAP, CSV or Parquet."),
    },
)
def log() -> None:
    """Read, check, compare and export timelines.

    RUN is the folder of a run, or its events.jsonl; runs/latest is the newest run.
    """


@log.command()
@RUN
@AS_JSON
def info(run: Path, *, as_json: bool) -> None:
    """Summarise a timeline: what was run, how it ended, and the number of entries of each kind."""
    from clew.log.log import Log
    from clew.log.summary import summarise

    summary = summarise(Log(run), run)
    if as_json:
        click.echo(msgspec.json.encode(summary).decode())
    else:
        _print_summary(summary)


@log.command("check")
@RUN
@AS_JSON
@click.pass_context
def check_log(ctx: click.Context, run: Path, *, as_json: bool) -> None:
    """Judge a run again from its log alone: every invariant, and whether the log is complete.

    docs/verdict.md lists the invariants. Exits with 1 when one was broken, when the log has a flaw, or when
    verdict.json says otherwise. The folder of a run with several fleets has a log for each; all are judged.
    """
    from clew.log.check import check, sentences
    from clew.log.log import Log, fleets_in

    fleets = fleets_in(run)
    findings = {name: check(Log(run / name)) for name in fleets or ("",)}
    if as_json:
        click.echo(msgspec.json.encode(findings if fleets else findings[""]).decode())
    else:
        for name, finding in findings.items():
            click.echo("\n".join([*([f"fleet {name}:"] if fleets else []), *sentences(finding)]))
    ctx.exit(0 if all(finding.ok for finding in findings.values()) else 1)


def _print_summary(summary: "Summary") -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    facts = Table(show_header=False, box=None)
    for name in ("run", "folder", "scenario", "law", "robots", "seed", "sim_s", "last_entry_s", "ended"):
        facts.add_row(name, _said(str(getattr(summary, name))))
    facts.add_row("verdict", _said(_judged(summary.verdict)))
    facts.add_row("entries", str(summary.entries))
    facts.add_row("versions", _said(", ".join(f"{name} {said}" for name, said in summary.versions.items())))
    facts.add_row("sources", _said(", ".join(f"{name} {count}" for name, count in summary.sources.items())))
    kinds = Table("kind", "entries")
    for kind, count in summary.kinds.items():
        kinds.add_row(_said(kind), str(count))
    console.print(facts)
    console.print(kinds)
    for flaw in summary.flaws:
        console.print(_said(f"not complete: {flaw}"), style="bold")


def _said(text: str) -> "Text":
    """Text from a log, without escape sequences and without rich markup."""
    from rich.text import Text

    return Text(plain(text))


def _judged(verdict: "Judged | None") -> str:
    if verdict is None:
        return "none"
    return f"{'OK' if verdict.ok else 'FAILED'}: {verdict.reason}"
