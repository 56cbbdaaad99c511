"""An entry of a timeline as one line for people, with the colour of its family if wanted."""

import os
import sys

import click
import msgspec

from protocol.plain import plain
from protocol.timeline import Entry, Record, kind_of

# By the part of a kind before the dot. What goes wrong is red, the reaction to it yellow.
COLOURS = {
    "promise": "bright_red",
    "fault": "red",
    "message": "red",
    "router": "red",
    "world": "red",
    "robot": "green",
    "link": "yellow",
    "fence": "bright_yellow",
    "view": "yellow",
    "law": "red",
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
NESTED_SHOWN = 2  # the ends of a gap, not the obstacles in sight
DIGITS = 4  # after the decimal point: a tenth of a millimetre, as in verdicts


def is_coloured(when: str) -> bool:
    """Whether stdout gets colours."""
    if when == "auto":
        return sys.stdout.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return when == "always"


def one_line(source: str, entry: Entry, said: str, *, coloured: bool = False) -> str:
    """Time, source, kind, and then the sentence or the fields.

    Args:
        source: who wrote the entry.
        entry: the entry.
        said: its sentence or its fields, on one line, without control characters.
        coloured: whether the kind has the colour of its family.
    """
    kind = f"{kind_of(entry.record):<18}"
    if coloured:
        kind = click.style(kind, fg=COLOURS[kind_of(entry.record).partition(".")[0]])
    return f"{entry.t_s:9.3f} {plain(source):>6} {kind} {said}".rstrip()


def fields_of(record: Record, *, exact: bool = False, only: frozenset[str] | None = None) -> str:
    """The fields of a record; of a long list only its length.

    Args:
        record: the record.
        exact: whether numbers keep all their digits, and short nested lists are shown.
        only: the fields to show; None: all.
    """
    fields = msgspec.to_builtins(record)
    del fields["kind"]
    fields = {name: value for name, value in fields.items() if only is None or name in only}
    return " ".join(f"{name}={_short(value, exact=exact)}" for name, value in fields.items())


def _short(value: object, *, exact: bool) -> str:
    """A field."""
    if isinstance(value, list | tuple):
        nested = not exact and any(isinstance(item, dict) for item in value)
        if len(value) > (NESTED_SHOWN if nested else ITEMS_SHOWN):
            return f"[{len(value)} items]"
    return plain(msgspec.json.encode(value if exact else _rounded(value)).decode())


def _rounded(value: object) -> object:
    """A value with its numbers rounded for people."""
    match value:
        case float():
            # A very small number must not be shown as zero.
            return round(value, DIGITS) or float(f"{value:.1g}")
        case list() | tuple():
            return [_rounded(item) for item in value]
        case dict():
            return {name: _rounded(item) for name, item in value.items()}
        case _:
            return value
