"""`clew log`: reads and judges timelines."""

import json
from pathlib import Path

import click
import msgspec
from rich.console import Console
from rich.table import Table
from rich.text import Text

from lab.check import check, sentences
from lab.export.verb import export
from lab.log import Log
from lab.options import AS_JSON
from lab.summary import Judged, Summary, summarise
from lab.timeline import Choice
from protocol.timeline import Entry
from world.recorder import line

RUN = click.argument("run", type=click.Path(path_type=Path))


@click.group()
def log() -> None:
    """Read a timeline. RUN is a run's folder, or its events.jsonl; runs/latest is the newest."""


@log.command()
@RUN
@AS_JSON
def info(run: Path, *, as_json: bool) -> None:
    """Summarise a timeline: what was run, how it ended, how many entries of which kind."""
    summary = summarise(Log(run), run)
    if as_json:
        click.echo(msgspec.json.encode(summary).decode())
    else:
        _print_summary(summary)


@log.command()
@RUN
@click.option("--source", multiple=True, help="Only entries by this source: world, r1, ...; may be repeated.")
@click.option("--kind", multiple=True, help="Only this kind; 'step.*' works too; may be repeated.")
@click.option("--robot", type=int, help="Only entries by this robot or about it.")
@click.option("--step", type=int, help="Only this switching step of the leader.")
@click.option("--from", "from_s", type=float, help="Only from this time on [simulated s].")
@click.option("--to", "to_s", type=float, help="Only up to this time [simulated s].")
@AS_JSON
def cat(run: Path, *, as_json: bool, **choice: tuple[str, ...] | float | None) -> None:
    """Print the entries of a timeline, all or those chosen, one a line."""
    read = Log(run)
    chosen = msgspec.convert(choice, Choice)
    for source, entry in read.lines:
        if chosen.takes(source, entry):
            click.echo(line(source, entry).decode().rstrip() if as_json else one_line(source, entry))
    _warn(read)


@log.command("check")
@RUN
@AS_JSON
@click.pass_context
def check_log(ctx: click.Context, run: Path, *, as_json: bool) -> None:
    """Judge S1 clearance, S2 separation, S3 authority and P1 to P6 again, from the log alone."""
    finding = check(Log(run))
    if as_json:
        click.echo(msgspec.json.encode(finding).decode())
    else:
        click.echo("\n".join(sentences(finding)))
    ctx.exit(0 if finding.ok else 1)


log.add_command(export)


def one_line(source: str, entry: Entry) -> str:
    """An entry for people: time, source, kind, then its fields."""
    fields = msgspec.to_builtins(entry.record)
    kind = fields.pop("kind")
    said = " ".join(f"{name}={json.dumps(value, separators=(',', ':'))}" for name, value in fields.items())
    return f"{entry.t_s:9.3f} {source:>6} {kind:<18} {said}".rstrip()


def _print_summary(summary: Summary) -> None:
    console = Console()
    facts = Table(show_header=False, box=None)
    for name in ("run", "scenario", "law", "robots", "seed", "sim_s", "ended"):
        facts.add_row(name, Text(str(getattr(summary, name))))
    facts.add_row("verdict", Text(_judged(summary.verdict)))
    facts.add_row("entries", str(summary.entries))
    facts.add_row("versions", ", ".join(f"{name} {value}" for name, value in summary.versions.items()))
    facts.add_row("sources", ", ".join(f"{name} {count}" for name, count in summary.sources.items()))
    kinds = Table("kind", "entries")
    for kind, count in summary.kinds.items():
        kinds.add_row(kind, str(count))
    console.print(facts)
    console.print(kinds)
    for flaw in summary.flaws:
        console.print(f"not complete: {flaw}", style="bold", markup=False)


def _judged(verdict: Judged | None) -> str:
    if verdict is None:
        return "none"
    return f"{'OK' if verdict.ok else 'FAILED'}: {verdict.reason}"


def _warn(read: Log) -> None:
    for flaw in read.flaws:
        click.echo(f"not complete: {flaw}", err=True)
