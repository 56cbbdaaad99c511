"""The tables of `docs/timeline.md`, from the types of `protocol/timeline/`."""

from inspect import cleandoc
from typing import get_args

import msgspec

from clew.manual.tables import Schema, name_of, nested, table
from protocol.timeline import Record


def kinds() -> str:
    """Each kind of entry, and the parts of entries."""
    schemas, components = msgspec.json.schema_components(get_args(Record))
    tables = [_kind(components[name_of(schema)], components) for schema in schemas]
    used = sorted({name for schema in schemas for name in nested(components[name_of(schema)], components)})
    parts = [_part(name, components) for name in used]
    return "\n".join(["## Kinds", "", *tables, "## Parts of entries", "", *parts])


def _kind(schema: Schema, components: Schema) -> str:
    kind = schema["properties"]["kind"]["enum"][0]
    fields = {name: field for name, field in schema["properties"].items() if name != "kind"}
    return f"### `{kind}`\n\n{cleandoc(schema['description'])}\n\n{table(fields, components)}"


def _part(name: str, components: Schema) -> str:
    schema = components[name]
    return f"### {name}\n\n{cleandoc(schema['description'])}\n\n{table(schema['properties'], components)}"
