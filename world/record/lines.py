"""Reads the lines of a timeline: sources and their entries.

Rule 1: a line is decoded once. It contains the fields of its stamp and of its record side by side. So each
        kind has a line type, made from both, and a function that separates the two.
Rule 2: many lines at once take two thirds of the time. One that is invalid, blank or in two parts makes all
        of them unreadable: then read them one by one.
"""

from collections.abc import Callable
from functools import reduce
from operator import or_
from typing import Any, get_args

import msgspec
from msgspec import NODEFAULT, Struct
from msgspec.structs import FieldInfo, fields

from protocol.frames import Count, Seconds
from protocol.timeline import Entry, Record
from protocol.timeline.base import Kind

Line = tuple[str, Entry]
"""A source and its entry."""


class Stamp(Struct, frozen=True, kw_only=True):
    """The fields of every line besides its record."""

    t_s: Seconds
    hlc: str
    source: str
    n: Count


def read_line(text: bytes) -> Line:
    """Read one line.

    Raises:
        msgspec.MsgspecError: it is invalid.
        ValueError: likewise.
    """
    line = _LINES.decode(text)
    return _PARTS[type(line)](line)


def read_lines(text: bytes) -> list[Line]:
    """Read lines at once, each with its newline.

    Raises:
        msgspec.MsgspecError: one of them is invalid.
        ValueError: likewise.
    """
    lines = _LINES.decode_lines(text)
    if text[-1:] != b"\n" or len(lines) != text.count(b"\n"):  # the decoder skips blanks, also newlines
        raise ValueError("not one entry in each line")
    return [_PARTS[type(line)](line) for line in lines]


def _type_of(kind: type[Kind]) -> type[Struct]:
    """The line type of this kind."""
    own = [(each.name, each.type, _default(each)) for each in (*fields(Stamp), *fields(kind))]
    tag = kind.__struct_config__.tag
    return msgspec.defstruct(f"{kind.__name__}Line", own, kw_only=True, tag=tag, tag_field="kind")


def _default(of: FieldInfo) -> Any:  # noqa: ANN401 - any value of a field
    if of.required:
        return msgspec.field()
    made = of.default_factory
    return of.default if made is NODEFAULT else msgspec.field(default_factory=made)


def _parting(kind: type[Kind]) -> Callable[[Any], Line]:
    """Separates a line; a generated function per kind takes half the time of a common one."""
    own = ", ".join(f"{name}=line.{name}" for name in kind.__struct_fields__)
    entry = f"Entry(n=line.n, t_s=line.t_s, hlc=line.hlc, record=Record({own}))"
    parting: Callable[[Any], Line] = eval(  # noqa: S307 - only names of our own fields
        f"lambda line: (line.source, {entry})", {"Entry": Entry, "Record": kind}
    )
    return parting


_PARTS = {_type_of(kind): _parting(kind) for kind in get_args(Record)}
_LINES = msgspec.json.Decoder[Any](reduce(or_, _PARTS))
