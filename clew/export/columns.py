"""The columns of a table of entries of one kind, derived from the kind's type."""

from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from msgspec import inspect

from protocol.timeline import Entry
from protocol.timeline.base import Kind
from world.record.lines import Stamp

UNITS = ("radps", "mps", "rad", "m", "s")
"""The units that may end a field's name."""


class Plain(Enum):
    """A type with one value."""

    NUMBER = auto()
    COUNT = auto()
    TEXT = auto()
    FLAG = auto()


@dataclass(frozen=True, slots=True)
class Part:
    """A type with fields of its own."""

    columns: tuple["Column", ...]


@dataclass(frozen=True, slots=True)
class Many:
    """A list of values of one type."""

    each: "Type"


@dataclass(frozen=True, slots=True)
class ByKey:
    """Values of one type, each with a text as its key."""

    each: "Type"


Type = Plain | Part | Many | ByKey


@dataclass(frozen=True, slots=True)
class Column:
    """A field of an entry."""

    name: str
    type: Type
    nullable: bool
    about: str

    @property
    def unit(self) -> str | None:
        """The unit that ends its name."""
        words = set(self.name.split("_")[1:])
        return next((unit for unit in UNITS if unit in words), None)


def columns_of(kind: type[Kind]) -> tuple[Column, ...]:
    """The columns of entries of this kind: the fields of every line, then the kind's own fields."""
    return (*_fields(Stamp), Column("kind", Plain.TEXT, nullable=False, about=""), *_fields(kind))


def row_of(source: str, entry: Entry, fields: dict[str, Any]) -> dict[str, Any]:
    """An entry as a row, by column name; `fields` is its record as plain data."""
    return {"t_s": entry.t_s, "hlc": entry.hlc, "source": source, "n": entry.n, **fields}


def _fields(struct: type[Any]) -> tuple[Column, ...]:
    info = inspect.type_info(struct)
    assert isinstance(info, inspect.StructType), struct
    return _columns(info)


def _columns(info: inspect.StructType) -> tuple[Column, ...]:
    return tuple(_column(field.encode_name, field.type) for field in info.fields)


def _column(name: str, info: inspect.Type) -> Column:
    nullable, about = False, ""
    while True:
        if isinstance(info, inspect.Metadata):
            about = about or str((info.extra_json_schema or {}).get("description", ""))
            info = info.type
        elif isinstance(info, inspect.UnionType):
            nullable = True
            (info,) = (each for each in info.types if not isinstance(each, inspect.NoneType))
        else:
            return Column(name, _type(info), nullable, about)


PLAIN = {
    inspect.FloatType: Plain.NUMBER,
    inspect.IntType: Plain.COUNT,
    inspect.StrType: Plain.TEXT,
    inspect.EnumType: Plain.TEXT,
    inspect.BoolType: Plain.FLAG,
}


def _type(info: inspect.Type) -> Type:
    match info:
        case inspect.Metadata(type=inner):
            return _type(inner)
        case inspect.StructType():
            return Part(_columns(info))
        case inspect.VarTupleType(item_type=each):
            return Many(_type(each))
        case inspect.DictType(value_type=each):
            return ByKey(_type(each))
        case _:
            return PLAIN[type(info)]  # a test makes the columns of every kind
