"""Writes `docs/timeline.md` from the types of `protocol/timeline.py`: `python -m lab.timeline_doc`."""

from pathlib import Path
from typing import Any, get_args

import msgspec

from protocol.timeline import Record

DOCUMENT = Path(__file__).parents[1] / "docs" / "timeline.md"

UNITS = frozenset({"m", "rad", "s"})

HEAD = """# The timeline

What happened in a run: `events.jsonl` in its folder, one JSON object a line. This page is made from the types
in `protocol/timeline.py` by `python -m lab.timeline_doc`; a test keeps the two the same.

The first line is the header, kind `run.started`: `schema` (`clew-timeline/1`), `run`, `seed`, `scenario`
(whole, so that the log can be judged by itself), `scenario_hash`, `speed` (null: as fast as the robots
answer), `started_at`, `versions`. Every line has these fields and then those of its kind:

| field | type | meaning |
|---|---|---|
| `t_s` | number, s | simulated time |
| `hlc` | string | hybrid logical clock of the source |
| `source` | string | who wrote it: `world`, `r1`, `r2`, ... |
| `n` | integer | the source's own count, from 1; a hole is an entry that never came |
| `kind` | string | one of those below |

Positions are in the world frame, angles in (-pi, pi], anti-clockwise. A line that the writer's death has torn
can only be the last.
"""


def document() -> str:
    """The whole page."""
    kinds = get_args(Record)
    schemas, components = msgspec.json.schema_components(kinds)
    tables = [_kind(components[_name(schema)], components) for schema in schemas]
    used = sorted({name for schema in schemas for name in _nested(components[_name(schema)], components)})
    parts = [_part(name, components) for name in used]
    return "\n".join([HEAD, "## Kinds", "", *tables, "## Parts of entries", "", *parts]).rstrip() + "\n"


def _name(reference: dict[str, Any]) -> str:
    return str(reference["$ref"].rpartition("/")[2])


def _kind(schema: dict[str, Any], components: dict[str, Any]) -> str:
    kind = schema["properties"]["kind"]["enum"][0]
    return f"### `{kind}`\n\n{schema['description']}\n\n{_table(schema, components)}"


def _part(name: str, components: dict[str, Any]) -> str:
    schema = components[name]
    return f"### {name}\n\n{schema['description']}\n\n{_table(schema, components)}"


def _table(schema: dict[str, Any], components: dict[str, Any]) -> str:
    fields = [(name, field) for name, field in schema["properties"].items() if name != "kind"]
    if not fields:
        return "No fields.\n"
    rows = [
        f"| `{name}` | {_type(field, components)}{_unit(name)} | {_bound(field)} | {_meaning(field)} |"
        for name, field in fields
    ]
    return "\n".join(["| field | type | bound | meaning |", "|---|---|---|---|", *rows, ""])


def _type(field: dict[str, Any], components: dict[str, Any]) -> str:
    if "anyOf" in field:
        return " or ".join(_type(choice, components) for choice in field["anyOf"])
    if "$ref" in field:
        target = components[_name(field)]
        return " or ".join(f"`{value}`" for value in target["enum"]) if "enum" in target else _name(field)
    if field["type"] == "array":
        return f"list of {_type(field['items'], components)}"
    if field["type"] == "object":
        return f"counts by key ({_type(field['additionalProperties'], components)})"
    return str(field["type"])


def _unit(name: str) -> str:
    unit = name.rpartition("_")[2]
    return f", {unit}" if unit != name and unit in UNITS else ""


def _bound(field: dict[str, Any]) -> str:
    choices = field.get("anyOf", [field])
    bounds = [(choice.get("minimum"), choice.get("maximum")) for choice in choices if "minimum" in choice]
    if bounds:
        low, high = bounds[0]
        return f"{low:.6g} to {'2^53' if high == 2**53 else format(high, '.6g')}"
    nouns = {"maxLength": "characters", "maxItems": "items", "maxProperties": "keys"}
    sizes = [f"at most {field[key]} {noun}" for key, noun in nouns.items() if key in field]
    patterns = [f"`{field['pattern']}`"] if "pattern" in field else []
    return ", ".join(sizes + patterns)


def _meaning(field: dict[str, Any]) -> str:
    choices = [field, *field.get("anyOf", [])]
    # "m" is what the type Length says of itself; the unit has a column of its own.
    return next((str(c["description"]) for c in choices if c.get("description", "m") != "m"), "")


def _nested(schema: dict[str, Any], components: dict[str, Any]) -> set[str]:
    found: set[str] = set()
    for field in schema["properties"].values():
        for choice in field.get("anyOf", [field]):
            target = choice.get("items", choice)
            if "$ref" in target and "enum" not in components[_name(target)]:
                found |= {_name(target)} | _nested(components[_name(target)], components)
    return found


if __name__ == "__main__":
    DOCUMENT.write_text(document(), encoding="utf-8")
