"""A timeline's lines as they are read again: sources and their entries."""

import msgspec
from msgspec import Struct

from protocol.frames import Count, Seconds
from protocol.timeline import Entry, Record

Line = tuple[str, Entry]
"""A source and its entry."""


class Stamp(Struct, frozen=True, kw_only=True):
    """What every line has beside its record."""

    t_s: Seconds
    hlc: str
    source: str
    n: Count


_STAMPS, _RECORDS = msgspec.json.Decoder(Stamp), msgspec.json.Decoder[Record](Record)


def read_line(text: bytes) -> Line:
    """The line in a text.

    Raises:
        msgspec.MsgspecError: there is none.
        ValueError: likewise.
    """
    stamp = _STAMPS.decode(text)
    return stamp.source, Entry(n=stamp.n, t_s=stamp.t_s, hlc=stamp.hlc, record=_RECORDS.decode(text))
