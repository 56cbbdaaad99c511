"""Writes plain data as TOML, for drawn fields and plans. Pure.

Rule 1: data that is read back is equal, floats to the last bit.
Rule 2: None values are left out.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

Table = Mapping[str, Any]


def toml_text(table: Table, schema: str | None = None) -> str:
    """The table as TOML; top-level sections and lists of tables get headings, deeper ones are inline.

    Args:
        table: the data to write.
        schema: the JSON Schema file for editors.
    """
    lines = [] if schema is None else [f"#:schema {schema}"]
    said = {key: value for key, value in table.items() if value is not None}
    sections = {key: value for key, value in said.items() if isinstance(value, Mapping) or _is_tables(value)}
    lines += _pairs({key: value for key, value in said.items() if key not in sections})
    for key, value in sections.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{key}]", *_pairs(value)]
            continue
        for each in value:
            lines += ["", f"[[{key}]]", *_pairs(each)]
    return "\n".join(lines) + "\n"


def _is_tables(value: object) -> bool:
    if not isinstance(value, Sequence) or isinstance(value, str):
        return False
    return len(value) > 0 and all(isinstance(each, Mapping) for each in value)


def _pairs(table: Table) -> Iterator[str]:
    return (f"{key} = {_value(value)}" for key, value in table.items() if value is not None)


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)  # TOML's strings, numbers, true and false are JSON's
