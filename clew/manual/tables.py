"""Tables of fields, in Markdown, from the JSON Schema that msgspec makes of our types."""

import re
from collections.abc import Mapping
from typing import Any

Schema = Mapping[str, Any]

# A name of ours ends in its unit, but for a bound's `_min` or `_max`.
_UNIT = re.compile(r"_(?P<unit>m|rad|mps|radps|s)(?:_min|_max)?$")
_UNIT_NAMES = {"m": "m", "rad": "rad", "mps": "m/s", "radps": "rad/s", "s": "s"}
# A type's description may begin with its unit, for editors; here the unit stands with the type.
_UNIT_FIRST = re.compile(r"^(?:m|rad|m/s|rad/s|s)(?:, |$)")
_COUNT_MAX = 2**53  # the bound of every count


def name_of(reference: Schema) -> str:
    """The name of the type that a reference leads to."""
    return str(reference["$ref"].rpartition("/")[2])


def table(fields: Mapping[str, Schema], components: Schema, *, defaults: bool = False) -> str:
    """A row for each field: type and unit, bound, default, meaning.

    Args:
        fields: their schemas, by name.
        components: the types that they may refer to.
        defaults: whether there is a column with the defaults.
    """
    if not fields:
        return "No fields.\n"
    rows = [["field", "type", "bound", *(["default"] if defaults else []), "meaning"]]
    rows.append(["---"] * len(rows[0]))
    for name, described in fields.items():
        field = without_null(described) if defaults else described
        cells = [f"`{name}`", f"{kind(field, components)}{unit(name)}", bound(field)]
        rows.append([*cells, *([default(field)] if defaults else []), meaning(field)])
    lines = [f"| {' | '.join(row)} |" for row in rows]
    lines[1] = lines[1].replace(" ", "")
    return "\n".join([*lines, ""])


def without_null(field: Schema) -> Schema:
    """A field without its null: TOML has no null, so such a field is left out instead."""
    choices = [choice for choice in field.get("anyOf", []) if choice != {"type": "null"}]
    if len(choices) != 1:
        return field
    return {**choices[0], **{key: value for key, value in field.items() if key != "anyOf"}}


def default(field: Schema) -> str:
    """The value of a field that a file leaves out."""
    if "default" not in field:
        return "required"
    value = field["default"]
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"  # as TOML spells it
    return "none" if value in (None, "", ()) else f"`{value}`"


def kind(field: Schema, components: Schema) -> str:
    """What a field's value is."""
    if "anyOf" in field:
        return " or ".join(kind(choice, components) for choice in field["anyOf"])
    target = components[name_of(field)] if "$ref" in field else field
    if "enum" in target:
        return " or ".join(f"`{value}`" for value in target["enum"])
    if "$ref" in field:
        return name_of(field)
    if field["type"] == "array":
        return _list(field, components)
    if field["type"] == "object":
        return f"counts by key ({kind(field['additionalProperties'], components)})"
    return str(field["type"])


def unit(name: str) -> str:
    """The unit that a field's name ends in, to stand behind its type."""
    found = _UNIT.search(name)
    return "" if found is None else f", {_UNIT_NAMES[found['unit']]}"


def bound(field: Schema) -> str:
    """What a field's value may be, and how long."""
    for choice in field.get("anyOf", [field]):
        if "minimum" in choice:
            return f"{choice['minimum']:.6g} to {_number(choice['maximum'])}"
        if "exclusiveMinimum" in choice:
            return f"> {choice['exclusiveMinimum']:.6g}, at most {_number(choice['maximum'])}"
    if "prefixItems" in field:
        return ""  # the type says how many
    nouns = {"Length": "character", "Items": "item", "Properties": "key"}
    sizes = [
        f"{word} {(size := field[f'{end}{what}'])} {noun}{'' if size == 1 else 's'}"
        for what, noun in nouns.items()
        for end, word in (("min", "at least"), ("max", "at most"))
        if f"{end}{what}" in field
    ]
    # A bar would end the table's cell.
    patterns = ["`" + field["pattern"].replace("|", "\\|") + "`"] if "pattern" in field else []
    return ", ".join(sizes + patterns)


def meaning(field: Schema) -> str:
    """What the type says of a field, without the unit."""
    said = [_UNIT_FIRST.sub("", c.get("description", ""), count=1) for c in (field, *field.get("anyOf", []))]
    return next(filter(None, said), "")


def nested(schema: Schema, components: Schema) -> set[str]:
    """The names of the types that a type's fields are made of, all the way down."""
    found: set[str] = set()
    for field in schema["properties"].values():
        for choice in field.get("anyOf", [field]):
            target = choice.get("items", choice)
            if "$ref" in target and "enum" not in components[name_of(target)]:
                found |= {name_of(target)} | nested(components[name_of(target)], components)
    return found


def _list(field: Schema, components: Schema) -> str:
    if "prefixItems" in field:
        return f"[{', '.join(kind(item, components) for item in field['prefixItems'])}]"
    return f"list of {kind(field['items'], components)}"


def _number(value: float) -> str:
    return "2^53" if value == _COUNT_MAX else format(value, ".6g")
