"""Parquet: one table for each kind of entry, with typed columns, their units and their meanings.

Rule 1: nested fields are a struct, a list is a list, and counts by key are a map. DuckDB, polars and pandas
        can unpack all of them.
Rule 2: every file has the run's header in its metadata, under `clew.run`.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import msgspec
import pyarrow as pa
from pyarrow.parquet import ParquetWriter

from clew.export.columns import ByKey, Column, Many, Part, Plain, Type, columns_of
from clew.export.exported import Exported
from clew.export.place import whole_folder
from clew.export.tables import fill, names_of
from clew.log.log import Log
from protocol.timeline import KINDS
from world.record.recorder import Header

PLAIN = {Plain.NUMBER: pa.float64(), Plain.COUNT: pa.int64(), Plain.TEXT: pa.string(), Plain.FLAG: pa.bool_()}


def export(log: Log, out: Path) -> Exported:
    """Write a log as a folder of Parquet files."""
    run = {"clew.run": msgspec.json.encode(log.header)}
    with whole_folder(out, names_of(".parquet")) as folder:
        _write_header(folder / "run.started.parquet", log.header, run)
        with ExitStack() as files:
            tables = {}
            for kind, record in KINDS.items():
                columns = columns_of(record)
                schema = pa.schema([_field(column) for column in columns], metadata=run)
                writer = files.enter_context(
                    ParquetWriter(folder / f"{kind}.parquet", schema, compression="zstd")
                )
                tables[kind] = _Table(writer, schema)
            return Exported(fill(tables, log.lines), log.flaws)


class _Table:
    def __init__(self, writer: ParquetWriter, schema: pa.Schema) -> None:
        self._writer, self._schema = writer, schema

    def add(self, rows: list[dict[str, Any]]) -> None:
        self._writer.write_table(pa.Table.from_pylist(rows, self._schema))


def _field(column: Column) -> pa.Field:
    about = {"unit": column.unit, "description": column.about}
    return pa.field(
        column.name,
        _arrow(column.type),
        nullable=column.nullable,
        metadata={name: said for name, said in about.items() if said},
    )


def _arrow(type_: Type) -> pa.DataType:
    match type_:
        case Plain():
            return PLAIN[type_]
        case Part(columns):
            return pa.struct([_field(column) for column in columns])
        case Many(each):
            return pa.list_(_arrow(each))
        case ByKey(each):
            return pa.map_(pa.string(), _arrow(each))


def _write_header(path: Path, header: Header, run: dict[str, bytes]) -> None:
    plain = msgspec.to_builtins(header)
    row = {
        name: msgspec.json.encode(value).decode() if isinstance(value, dict) else value
        for name, value in plain.items()
    }
    table = pa.Table.from_pylist([row]).replace_schema_metadata(run)
    with ParquetWriter(path, table.schema) as writer:
        writer.write_table(table)
