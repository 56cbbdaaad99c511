"""JSON Schemas of the lines of a log, each without references, because some tools do not resolve them."""

from typing import Any

import msgspec

from protocol.timeline.base import Kind
from world.record.lines import Stamp
from world.record.recorder import Header

Schema = dict[str, Any]


def schema_of(kind: type[Kind] | type[Header]) -> Schema:
    """The schema of a line of this kind."""
    (own, stamp), parts = msgspec.json.schema_components([kind, Stamp])
    whole, common = _whole(own, parts), _whole(stamp, parts)
    required = dict.fromkeys([*common["required"], *whole.get("required", ())])
    return {
        **whole,
        "properties": common["properties"] | whole["properties"],
        "required": list(required),
    }


def _whole(schema: Any, parts: dict[str, Schema]) -> Any:  # noqa: ANN401 - JSON of any depth
    match schema:
        case {"$ref": str(name), **rest}:
            return _whole(parts[name.rsplit("/", 1)[-1]] | rest, parts)
        case dict():
            return {key: _whole(value, parts) for key, value in schema.items()}
        case list():
            return [_whole(each, parts) for each in schema]
        case _:
            return schema
