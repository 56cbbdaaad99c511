"""CSV and Parquet, read back with common tools: the same values with the same types."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import duckdb
import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from pyarrow import parquet

from clew.export import csv_files, tables
from clew.export import parquet as parquet_files
from clew.export.columns import Column, Part, Plain, columns_of
from clew.log.log import Log
from protocol.timeline import KINDS
from tests.support.campaigns import clew
from tests.support.logs.exports import one_of_each_kind, rows_of
from tests.support.logs.logs import recorded
from tests.support.runs import Runs
from tests.support.strategies.examples import examples
from world.record.lines import Line

READ: dict[Plain, Callable[[str], object]] = {
    Plain.NUMBER: float,
    Plain.COUNT: int,
    Plain.TEXT: str,
    Plain.FLAG: {"true": True, "false": False}.get,
}


@pytest.fixture(scope="module")
def run(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return runs.copy(tmp_path_factory.mktemp("lively") / "run", "grove", faults="leader-killed")


def sql(query: str) -> list[tuple[Any, ...]]:
    return duckdb.execute(query).fetchall()


def types_in(query: str) -> dict[str, str]:
    return {name: kind for name, kind, *_ in sql(f"DESCRIBE {query}")}


@settings(max_examples=examples(5), suppress_health_check=[HealthCheck.too_slow])
@given(lines=one_of_each_kind())
def test_parquet_holds_every_kind_with_every_value(
    tmp_path_factory: pytest.TempPathFactory, lines: list[Line]
) -> None:
    folder = recorded(tmp_path_factory.mktemp("log") / "run", lines)
    exported = parquet_files.export(Log(folder), folder / "parquet")
    assert exported.entries == len(lines)
    for kind, rows in rows_of(lines).items():
        table = duckdb.read_parquet(f"{folder}/parquet/{kind}.parquet")
        assert [dict(zip(table.columns, row, strict=True)) for row in table.fetchall()] == rows


@settings(max_examples=examples(5), suppress_health_check=[HealthCheck.too_slow])
@given(lines=one_of_each_kind())
def test_csv_holds_every_kind_with_every_value(
    tmp_path_factory: pytest.TempPathFactory, lines: list[Line]
) -> None:
    folder = recorded(tmp_path_factory.mktemp("log") / "run", lines)
    csv_files.export(Log(folder), folder / "csv")
    for kind, rows in rows_of(lines).items():
        with (folder / "csv" / f"{kind}.csv").open(newline="", encoding="utf-8") as file:
            read = [whole(columns_of(KINDS[kind]), cells) for cells in csv.DictReader(file)]
        assert read == [null_if_empty(columns_of(KINDS[kind]), row) for row in rows]


def whole(fields: tuple[Column, ...], cells: dict[str, str], before: str = "") -> dict[str, Any] | None:
    """A row rebuilt from its cells; None if a nested value with these fields is null."""
    row: dict[str, Any] = {}
    for field in fields:
        name = f"{before}{field.name}"
        if isinstance(field.type, Part):
            row[field.name] = whole(field.type.columns, cells, f"{name}.")
        elif cells[name] == "" and (field.nullable or field.type is not Plain.TEXT):
            row[field.name] = None
        elif isinstance(field.type, Plain):
            row[field.name] = READ[field.type](cells[name])
        else:
            row[field.name] = json.loads(cells[name])
    return None if before and not any(value is not None for value in row.values()) else row


def null_if_empty(fields: tuple[Column, ...], row: dict[str, Any]) -> dict[str, Any]:
    """The value without differences that CSV cannot express: an empty text that may be null is null."""
    return row | {
        field.name: row[field.name] or None for field in fields if field.nullable and row[field.name] == ""
    }


def test_duckdb_reads_the_types_of_parquet(run: Path) -> None:
    parquet_files.export(Log(run), run / "parquet")
    found = types_in(f"SELECT * FROM '{run}/parquet/step.planned.parquet'")
    assert found["t_s"] == "DOUBLE"
    assert found["n"] == found["step"] == found["gap"] == "BIGINT"
    assert found["law"] == "VARCHAR"
    assert found["target"] == "STRUCT(x_m DOUBLE, y_m DOUBLE)"
    assert found["gaps"].endswith("width_m DOUBLE, delta_rad DOUBLE, passable BOOLEAN)[]")
    assert types_in(f"SELECT sent FROM '{run}/parquet/traffic.counted.parquet'") == {
        "sent": "MAP(VARCHAR, BIGINT)"
    }


def test_a_query_on_a_kind_that_never_occurred_has_an_answer(run: Path) -> None:
    parquet_files.export(Log(run), run / "parquet")
    assert sql(f"SELECT count(*), max(away_s) FROM '{run}/parquet/router.found.parquet'") == [(0, None)]


def test_parquet_names_units_meanings_and_the_run(run: Path) -> None:
    parquet_files.export(Log(run), run / "parquet")
    schema = parquet.read_schema(run / "parquet" / "step.planned.parquet")
    assert schema.field("length_m").metadata[b"unit"] == b"m"
    assert schema.field("heading_rad").metadata[b"unit"] == b"rad"
    assert (
        schema.field("cost_to_go_m").metadata[b"description"] == b"from the target to the goal; null: no goal"
    )
    assert b"unit" not in (schema.field("step").metadata or {})
    header = Log(run).header
    for path in (run / "parquet").iterdir():
        told = parquet.read_schema(path).metadata[b"clew.run"]
        assert msgspec.json.decode(told, type=type(header)) == header


def test_duckdb_infers_the_types_of_csv(run: Path) -> None:
    csv_files.export(Log(run), run / "csv")
    found = types_in(f"SELECT * FROM '{run}/csv/order.accepted.csv'")
    assert found["t_s"] == found["target.x_m"] == found["reach_m"] == "DOUBLE"
    assert found["n"] == found["robot"] == "BIGINT"
    assert found["source"] == "VARCHAR"
    assert types_in(f"SELECT sensed FROM '{run}/csv/strand.formed.csv'") == {"sensed": "BOOLEAN"}


@pytest.mark.parametrize("kind", ["pose.sampled", "order.accepted", "authority.granted"])
def test_csv_parquet_and_the_log_are_equal_in_duckdb(
    run: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tables, "ROWS_AT_ONCE", 100)  # so that tables are written in several batches
    csv_files.export(Log(run), run / "csv")
    parquet_files.export(Log(run), run / "parquet")
    named = "t_s, source, n, epoch" if kind != "pose.sampled" else "t_s, source, n, x_m, heading_rad"
    log = f"SELECT {named} FROM '{run}/events.jsonl' WHERE kind = '{kind}' ORDER BY ALL"
    from_log = sql(log)
    assert len(from_log) > 100
    for suffix in ("csv", "parquet"):
        assert sql(f"SELECT {named} FROM '{run}/{suffix}/{kind}.{suffix}' ORDER BY ALL") == from_log


def test_the_header_is_a_table(run: Path) -> None:
    for suffix, export in (("csv", csv_files.export), ("parquet", parquet_files.export)):
        export(Log(run), run / suffix)
        header = f"'{run}/{suffix}/run.started.{suffix}'"
        assert sql(f"SELECT seed, schema, scenario->>'$.name' FROM {header}") == [
            (1, "clew-timeline/1", "grove")
        ]


def test_a_unit_is_the_last_word_of_a_fields_name() -> None:
    units = {column.name: column.unit for kind in KINDS.values() for column in columns_of(kind)}
    assert units["silent_since_s"] == units["t_s"] == "s"
    assert units["ranges_m"] == "m"
    assert units["heading_rad"] == "rad"
    assert units["revolutions"] is units["n"] is units["torn_bytes"] is None


def test_unreadable_lines_are_reported_and_everything_else_is_exported(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "run", [])
    with (folder / "events.jsonl").open("ab") as file:
        file.write(b'{"t_s":0.5,"hlc":"0/0","source":"world","n":1,"kind":"robot.sneezed"}\n')
        file.write(
            b'{"t_s":1.0,"hlc":"0/0","source":"world","n":2,"kind":"run.ended","reason":"done"}\n{"t_s"'
        )
    said = clew("log", "export", folder, "--to", "csv")
    assert said.exit_code == 0
    assert said.stdout.strip() == str(folder / "csv")
    assert said.stderr.splitlines() == [
        "not complete: line 4 is torn: dropped",
        "not complete: 1 entries of a kind that this program does not know: 'robot.sneezed'",
    ]
    assert sql(f"SELECT reason FROM '{folder}/csv/run.ended.csv'") == [("done",)]
