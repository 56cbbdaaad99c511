"""Logs to export."""

from typing import Any

import msgspec
from hypothesis import strategies as st

from clew.export.columns import row_of
from protocol.timeline import KINDS, kind_of
from tests.support.logs.logs import numbered
from tests.support.strategies.message_strategies import values_of
from world.record.lines import Line


def one_of_each_kind() -> st.SearchStrategy[list[Line]]:
    """Logs with an entry of every kind, with any content."""
    return st.tuples(*map(values_of, KINDS.values())).map(
        lambda records: numbered(tuple(("world", record) for record in records))
    )


def rows_of(lines: list[Line]) -> dict[str, list[dict[str, Any]]]:
    """The rows of a log's tables, by kind."""
    rows: dict[str, list[dict[str, Any]]] = {kind: [] for kind in KINDS}
    for source, entry in lines:
        fields = msgspec.json.decode(msgspec.json.encode(entry.record))  # as in the log: lists, no tuples
        rows[kind_of(entry.record)].append(row_of(source, entry, fields))
    return rows
