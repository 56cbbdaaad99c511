"""CSV: one file for each kind of entry, with a column for each number, text or flag in it.

Rule 1: nested fields are columns with a dot, as `target.x_m`. A list or a map is JSON in one column.
Rule 2: an empty cell is null or an empty text.
"""

import csv
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TextIO

import msgspec

from clew.export.columns import Column, Part, Plain, columns_of
from clew.export.exported import Exported
from clew.export.place import whole_folder
from clew.export.tables import fill, names_of
from clew.log.log import Log
from protocol.timeline import KINDS
from world.record.recorder import Header


def export(log: Log, out: Path) -> Exported:
    """Write a log as a folder of CSV files."""
    with whole_folder(out, names_of(".csv")) as folder:
        _write_header(folder / "run.started.csv", log.header)
        with ExitStack() as files:
            tables = {
                kind: _Table(
                    files.enter_context((folder / f"{kind}.csv").open("w", newline="", encoding="utf-8")),
                    columns_of(record),
                )
                for kind, record in KINDS.items()
            }
            return Exported(fill(tables, log.lines), log.flaws)


class _Table:
    def __init__(self, file: TextIO, columns: tuple[Column, ...]) -> None:
        self._columns = columns
        self._writer = csv.writer(file)
        self._writer.writerow(_names(columns))

    def add(self, rows: list[dict[str, Any]]) -> None:
        self._writer.writerows(list(_cells(self._columns, row)) for row in rows)


def _names(columns: Iterable[Column], before: str = "") -> Iterator[str]:
    for column in columns:
        if isinstance(column.type, Part):
            yield from _names(column.type.columns, f"{before}{column.name}.")
        else:
            yield f"{before}{column.name}"


def _cells(columns: Iterable[Column], row: dict[str, Any] | None) -> Iterator[object]:
    for column in columns:
        value = None if row is None else row[column.name]
        if column.type is Plain.FLAG:
            yield None if value is None else str(value).lower()  # as JSON, SQL and pandas write it
        elif isinstance(column.type, Plain):
            yield value
        elif isinstance(column.type, Part):
            yield from _cells(column.type.columns, value)
        else:
            yield None if value is None else msgspec.json.encode(value).decode()


def _write_header(path: Path, header: Header) -> None:
    plain = msgspec.to_builtins(header)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(plain)
        writer.writerow(
            msgspec.json.encode(value).decode() if isinstance(value, dict) else value
            for value in plain.values()
        )
