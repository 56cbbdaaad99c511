"""Tables of entries, one for each kind, written in batches."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import msgspec

from clew.export.columns import row_of
from protocol.timeline import KINDS
from world.record.lines import Line
from world.record.recorder import Header

HEADER = str(Header.__struct_config__.tag)
ROWS_AT_ONCE = 20_000  # of pose.sampled: 15 MB


class Table(Protocol):
    """A table that takes the entries of one kind."""

    def add(self, rows: list[dict[str, Any]]) -> None:
        """Append these rows."""


def names_of(suffix: str) -> frozenset[str]:
    """The names of the files of an export: the header's, and one for each kind."""
    return frozenset(f"{kind}{suffix}" for kind in (HEADER, *KINDS))


def fill(tables: Mapping[str, Table], lines: Iterable[Line]) -> int:
    """Write all entries, each into the table of its kind; returns their number."""
    waiting: defaultdict[str, list[dict[str, Any]]] = defaultdict(list)
    count = 0
    for source, entry in lines:
        count += 1
        fields = msgspec.to_builtins(entry.record)
        rows = waiting[fields["kind"]]
        rows.append(row_of(source, entry, fields))
        if len(rows) == ROWS_AT_ONCE:
            tables[fields["kind"]].add(waiting.pop(fields["kind"]))
    for kind, rows in waiting.items():
        tables[kind].add(rows)
    return count
