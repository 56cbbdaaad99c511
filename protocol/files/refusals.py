"""Rewords msgspec's validation errors: path, bound, and the user's value, always in one line."""

import re
from collections.abc import Iterator
from typing import Any

from msgspec import inspect

from protocol.files.names import did_you_mean

# The form of msgspec's errors: what is wrong, then where, unless it is the whole value.
_REFUSAL = re.compile(r"(?P<what>.*?)(?: - at `\$(?P<path>.*)`)?", re.DOTALL)
_EXPECTED = re.compile(r"Expected `(?P<kind>[^`]*)`(?: (?P<bound>matching regex .*|[^,]*))?(?:, got .*)?")
_FIELD = re.compile(r"Object (?P<verb>missing required|contains unknown) field `(?P<name>.*)`", re.DOTALL)
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")
_UNIT = re.compile(r"_(?P<unit>m|rad|mps|radps|s)(?:_min|_max)?(?:\[\d+\])?$")
_UNIT_NAMES = {"m": " m", "rad": " rad", "mps": " m/s", "radps": " rad/s", "s": " s"}
_KIND_NAMES = {
    "int": "an integer",
    "float": "a number",
    "str": "a string",
    "array": "a list",
    "object": "an object",
}
_SAID_LENGTH_MAX = 60  # a line with its path and bound should fit on a screen


def one_line(refusal: str, raw: object, wanted: type) -> str:
    """A validation error, completed with the user's value: `$.fleet.robots: must be >= 1, got 0`.

    Args:
        refusal: msgspec's sentence.
        raw: what was to be converted.
        wanted: the type it was to be converted to.
    """
    parts = _REFUSAL.fullmatch(refusal)
    assert parts is not None, refusal
    what, path = parts["what"], parts["path"] or ""
    if what.startswith("$"):  # one of our own relations, which names its path itself
        return what
    value = at(raw, path)
    if (field := _FIELD.fullmatch(what)) is not None:
        return f"${path}: {_field(field, value, path, wanted)}"
    if (expected := _EXPECTED.fullmatch(what)) is not None:
        said = _in_words(wanted, path) if isinstance(value, str) else {}
        bound, near = said.get("words") or _bound(expected, path), said.get("names", ())
        hint = did_you_mean(str(value), near) or _as_list(expected["kind"], value, path)
        return f"${path}: must be {bound}, got {short(value)}{hint}"
    if what.startswith("Invalid"):  # of an enum, a literal, or the field that says which shape it is
        choices = sorted({choice for kind in _kinds(wanted, path) for choice in _choices(kind)})
        return f"${path}: must be {_one_of(choices)}, got {short(value)}{did_you_mean(str(value), choices)}"
    if ", got" in what or isinstance(value, dict):  # a whole object would not help the user
        return f"${path}: {what}"
    return f"${path}: {what}, got {short(value)}"


def at(raw: object, path: str) -> object:
    """The value at one of msgspec's paths, `.fleet.places[2]`."""
    for key, index in _STEP.findall(path):
        assert isinstance(raw, dict | list | tuple), path  # msgspec has followed this path before
        raw = raw[key or int(index)]
    return raw


def short(value: object) -> str:
    """A value on one line, cut off where it is long."""
    said = repr(value)
    return said if len(said) <= _SAID_LENGTH_MAX else f"{said[: _SAID_LENGTH_MAX - 3]}..."


def _bound(expected: re.Match[str], path: str) -> str:
    kind, bound = expected["kind"].removesuffix(" | null"), expected["bound"] or ""
    if bound.startswith(("<", ">")):
        unit = _UNIT.search(path)
        return f"{bound}{_UNIT_NAMES[unit['unit']] if unit else ''}"
    return f"{_KIND_NAMES.get(kind, kind)} {bound}".rstrip()


def _as_list(kind: str, value: object, path: str) -> str:
    """How to write one value as a list, where a list is wanted."""
    if kind.removesuffix(" | null") != "array" or not isinstance(value, str | dict):
        return ""
    if isinstance(value, str):
        return f"; did you mean [{short(value)}]?"
    name = ".".join(key for key, _ in _STEP.findall(path) if key)
    return f"; in TOML, write [[{name}]]"


def _field(field: re.Match[str], value: object, path: str, wanted: type) -> str:
    assert isinstance(value, dict), path  # only objects have fields
    if field["verb"] == "missing required":
        # Their representations, since a key of TOML or JSON may hold a line break.
        names = ", ".join(short(name).strip("'") for name in value)
        return f"must have the field {field['name']}, got {names or 'no field'}"
    known = [name for kind in _kinds(wanted, path) for name in _names(kind, value)]
    got = f"{short(field['name'])} = {short(value[field['name']])}"
    return f"must have no field but {', '.join(known)}, got {got}{did_you_mean(field['name'], known)}"


def _one_of(choices: list[str]) -> str:
    return f"one of {', '.join(choices)}" if len(choices) > 1 else repr(choices[0])


def _kinds(wanted: type, path: str) -> list[inspect.Type]:
    """The types that are allowed at a path."""
    return [bare for kind in _whole(wanted, path) for bare in _bare(kind)]


def _whole(wanted: type, path: str) -> list[inspect.Type]:
    """The types that are allowed at a path, with what is said of them."""
    kinds: list[inspect.Type] = [inspect.type_info(wanted)]
    for key, index in _STEP.findall(path):
        kinds = [inner for kind in kinds for bare in _bare(kind) for inner in _inner(bare, key, index)]
    return kinds


def _in_words(wanted: type, path: str) -> dict[str, Any]:
    """The pattern of a text at a path in `words`, and the `names` that fit it, where its type says so."""
    found = (extra for kind in _whole(wanted, path) for extra in _extras(kind) if "words" in extra)
    return next(found, {})


def _extras(kind: inspect.Type) -> Iterator[dict[str, Any]]:
    match kind:
        case inspect.Metadata(type=inner, extra=extra):
            yield extra or {}
            yield from _extras(inner)
        case inspect.UnionType(types=types):
            for inner in types:
                yield from _extras(inner)
        case _:
            pass


def _bare(kind: inspect.Type) -> Iterator[inspect.Type]:
    match kind:
        case inspect.Metadata(type=inner):
            yield from _bare(inner)
        case inspect.UnionType(types=types):
            for inner in types:
                yield from _bare(inner)
        case _:
            yield kind


def _inner(kind: inspect.Type, key: str, index: str) -> Iterator[inspect.Type]:
    match kind:
        case inspect.StructType(tag_field=tag_field, tag=tag) if key and key == tag_field:
            yield inspect.LiteralType((tag,))
        case inspect.StructType(fields=fields):
            yield from (field.type for field in fields if field.encode_name == key)
        case inspect.VarTupleType(item_type=item):
            yield item
        case inspect.TupleType(item_types=items):
            yield items[int(index)]
        case _:
            pass  # the other branch of a union


def _choices(kind: inspect.Type) -> Iterator[str]:
    match kind:
        case inspect.EnumType(cls=cls):
            yield from (str(member.value) for member in cls)
        case inspect.LiteralType(values=values):
            yield from map(str, values)
        case _:
            pass


def _names(kind: inspect.Type, value: dict[str, object]) -> Iterator[str]:
    """The fields that an object of this kind may have."""
    match kind:
        case inspect.StructType(tag_field=str(tag_field), tag=tag) if value.get(tag_field) != tag:
            pass  # another of the tagged union
        case inspect.StructType(tag_field=tag_field, fields=fields):
            yield from ([] if tag_field is None else [tag_field])
            yield from (field.encode_name for field in fields)
        case _:
            pass
