"""Writes `docs/timeline.md` from the types of `protocol/timeline/`: `python -m clew.manual.timeline`."""

from typing import get_args

import msgspec

from clew.manual.tables import Schema, name_of, nested, table
from protocol.root import ROOT
from protocol.timeline import Record

DOCUMENT = ROOT / "docs" / "timeline.md"

HEAD = """# The timeline

What happened in a run: `events.jsonl` in its folder, one JSON object a line. This page is made from the types
in `protocol/timeline/` by `python -m clew.manual.timeline`; a test keeps the two the same.

The first line is the header, kind `run.started`: `schema` (`clew-timeline/1`), `run`, `seed`, `scenario`
(whole, so that the log can be judged by itself), `scenario_hash`, `speed` (null: as fast as the robots
answer), `started_at`, `versions`, `faults` (the fault plan, whole, as docs/faults.md has it; null: none; of
what was asked for by hand the entries `fault.injected` tell). Every line has these fields and then those of
its kind:

| field | type | meaning |
|---|---|---|
| `t_s` | number, s | simulated time |
| `hlc` | string | when the source made it, by its hybrid logical clock |
| `source` | string | who wrote it: `world`, `r1`, `r2`, ... |
| `n` | integer | the source's own count, from 1; a hole is an entry that never came |
| `kind` | string | one of those below |

Lines stand in the order in which the world recorded them, not sorted by `t_s`: a robot's entry may come after
one of the world's with a later time. Within one source, `n` and `t_s` go up.

`hlc` is Zenoh's hybrid logical clock as `NTP64/id`: the source's time in units of 2^-32 s since 1970, as one
decimal number, and then the id of its Zenoh session. It follows the wall clock and the time stamps that
others send, and no two of one session are the same. In a rehearsal the time is the simulated one, since 1970,
and the id is the source.

Positions are in the world frame, angles in (-pi, pi], anti-clockwise. A line that the writer's death has torn
can only be the last.
"""


def document() -> str:
    """The whole page."""
    kinds = get_args(Record)
    schemas, components = msgspec.json.schema_components(kinds)
    tables = [_kind(components[name_of(schema)], components) for schema in schemas]
    used = sorted({name for schema in schemas for name in nested(components[name_of(schema)], components)})
    parts = [_part(name, components) for name in used]
    return "\n".join([HEAD, "## Kinds", "", *tables, "## Parts of entries", "", *parts]).rstrip() + "\n"


def _kind(schema: Schema, components: Schema) -> str:
    kind = schema["properties"]["kind"]["enum"][0]
    fields = {name: field for name, field in schema["properties"].items() if name != "kind"}
    return f"### `{kind}`\n\n{schema['description']}\n\n{table(fields, components)}"


def _part(name: str, components: Schema) -> str:
    schema = components[name]
    return f"### {name}\n\n{schema['description']}\n\n{table(schema['properties'], components)}"


if __name__ == "__main__":
    DOCUMENT.write_text(document(), encoding="utf-8")
