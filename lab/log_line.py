"""An entry of a timeline as one line for people, in the colour of its family where colours are wanted."""

import json
import os
import sys

import click
import msgspec

from lab.timeline import kind_of
from protocol.timeline import Entry

# By what stands before the dot of a kind. What goes wrong is red, what is done about it yellow.
COLOURS = {
    "promise": "bright_red",
    "fault": "red",
    "message": "red",
    "router": "red",
    "world": "red",
    "robot": "green",
    "link": "yellow",
    "muster": "yellow",
    "leader": "yellow",
    "strand": "yellow",
    "step": "bright_cyan",
    "segment": "cyan",
    "goal": "bright_green",
    "route": "bright_red",
    "run": "bright_green",
    "order": "blue",
    "authority": "blue",
    "body": "magenta",
    "pose": "bright_black",
    "scan": "bright_black",
    "traffic": "bright_black",
}

ITEMS_SHOWN = 20  # the order of a strand, not the rays of a scan

WHEN = click.option(
    "--color",
    type=click.Choice(["auto", "always", "never"]),
    default="auto",
    show_default=True,
    help="auto: on a terminal, unless NO_COLOR is set.",
)


def is_coloured(when: str) -> bool:
    """Whether stdout gets colours."""
    if when == "auto":
        return sys.stdout.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return when == "always"


def _short(value: object) -> str:
    """A field; of a long list, as of a scan's ranges, only how long it is."""
    if isinstance(value, list | tuple) and len(value) > ITEMS_SHOWN:
        return f"[{len(value)} items]"
    return json.dumps(value, separators=(",", ":"))


def one_line(source: str, entry: Entry, *, coloured: bool = False) -> str:
    """Time, source, kind, then the kind's fields; of long lists only how long they are."""
    fields = msgspec.to_builtins(entry.record)
    kind = f"{fields.pop('kind'):<18}"
    said = " ".join(f"{name}={_short(value)}" for name, value in fields.items())
    if coloured:
        kind = click.style(kind, fg=COLOURS[kind_of(entry.record).partition(".")[0]])
    return f"{entry.t_s:9.3f} {source:>6} {kind} {said}".rstrip()
