"""Keeps objects as numbers, so that states can be compared and merged.

Rule 1: a number stands for the whole content: contents with the same number are equal in every value. Equal
        contents may have two numbers where values are one object in one and two in the other: 1 in 2,000.
Rule 2: `load` returns a copy, which its caller may change.
Rule 3: constants are shared, not copied: objects that nothing changes, or whose changes have no effect.
        Random streams are such, since what is explored has no noise.
Rule 4: inside an object, values that have numbers of their own are written as those.
Rule 5: large objects that nothing changes once they are made are compared once, and then shared.
"""

import io
import pickle
from collections.abc import Callable, Collection, Hashable, Iterable, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from hashlib import blake2b
from importlib import import_module
from operator import attrgetter
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

T = TypeVar("T")
H = TypeVar("H", bound=Hashable)

APART_BYTES = 2048  # arrays from this size on are kept apart: maps of guidance, equal in most snapshots
_DIGEST_BYTES = 16  # 2**64 contents until one pair is likely to be confused


class Numbers(Generic[H]):
    """Values that do not change, such as messages: each once."""

    def __init__(self) -> None:
        self._kept: dict[int, H] = {}
        self._numbers: dict[H, int] = {}
        self._by_id: dict[int, int] = {}  # faster than to compare; what is kept stays alive
        self._count = 0

    def __len__(self) -> int:
        return len(self._kept)

    def __getitem__(self, number: int) -> H:
        return self._kept[number]

    def add(self, value: H) -> int:
        """The number of the value."""
        number = self._by_id.get(id(value))
        if number is not None:
            return number
        number = self._numbers.setdefault(value, self._count)
        if number == self._count:
            self._count += 1
            self._kept[number] = value
            self._by_id[id(value)] = number
        return number

    def keep_only(self, numbers: Collection[int]) -> None:
        """Forget all others. Their numbers do not come again, so a value may get another one later."""
        self._kept = {number: self._kept[number] for number in numbers}
        self._numbers = {value: number for number, value in self._kept.items()}
        self._by_id = {id(value): number for number, value in self._kept.items()}


class _Kept(NamedTuple):
    """One content."""

    digest: bytes
    stream: bytes
    arrays: tuple[int, ...]


Reducer = Callable[[Any], Any]


class _Reducers(dict[type, Reducer]):
    """How objects of each type are written. Frozen data classes with slots take long without this."""

    def __missing__(self, kind: type) -> Reducer:
        if not (is_dataclass(kind) and "__slots__" in vars(kind)):
            raise KeyError(kind)
        values = attrgetter(*(field.name for field in fields(kind)), "__class__")

        def reducer(thing: object) -> tuple[Any, ...]:
            return _rebuilt, values(thing)

        self[kind] = reducer
        return reducer


def _rebuilt(*values: Any) -> object:  # noqa: ANN401 - the values of any fields, and the type
    *contents, kind = values
    thing = object.__new__(kind)
    for field, value in zip(fields(kind), contents, strict=True):
        object.__setattr__(thing, field.name, value)
    return thing


class _Pickler(pickle.Pickler):
    """Calls no method of ours for most objects, which would take most of the time."""

    def __init__(self, table: _Reducers) -> None:
        self._file, self._buffers = io.BytesIO(), list[bytes]()
        super().__init__(self._file, protocol=5, buffer_callback=self._is_within)
        self.dispatch_table = table

    def _is_within(self, buffer: pickle.PickleBuffer) -> bool:
        raw = buffer.raw()
        if raw.nbytes < APART_BYTES:
            return True
        self._buffers.append(raw.tobytes())
        return False

    def pickled(self, thing: object) -> tuple[bytes, list[bytes]]:
        self.dump(thing)
        return self._file.getvalue(), self._buffers


def _constant(number: int) -> object:
    raise AssertionError(f"constant {number}: `_Unpickler` has it")


def _value(number: int) -> object:
    raise AssertionError(f"value {number}: `_Unpickler` has it")


class _Unpickler(pickle.Unpickler):
    def __init__(
        self, stream: bytes, buffers: Iterable[bytes], constants: Sequence[object], values: Numbers[Any]
    ) -> None:
        super().__init__(io.BytesIO(stream), buffers=map(bytearray, buffers))
        self._own = {_constant.__name__: constants.__getitem__, _value.__name__: values.__getitem__}

    def find_class(self, module: str, name: str) -> object:
        own = self._own.get(name) if module == __name__ else None
        return _found(module, name) if own is None else own


@cache
def _found(module: str, name: str) -> object:
    found: object = import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    return found


class Snapshots(Generic[T]):
    """Objects that change, such as cores: each content once."""

    def __init__(
        self,
        constants: Sequence[object],
        values: Numbers[Any],
        value_types: Iterable[type] = (),
        fixed_types: Iterable[type] = (),
    ) -> None:
        """Values of some types are kept by `values` (rule 4), objects of others are fixed (rule 5)."""
        self._constants = [np.random.default_rng(0), *constants]
        self._values = values
        self._by_id = {id(constant): number for number, constant in enumerate(self._constants)}
        self._table = _Reducers(dict.fromkeys(map(type, self._constants), self._constant))
        self._table.update(dict.fromkeys(value_types, self._value))
        self._table.update(dict.fromkeys(fixed_types, self._fixed))
        self._fixed_numbers: dict[bytes, int] = {}
        self._alive: list[object] = []  # so that no other object gets their ids
        self._kept: dict[int, _Kept] = {}
        self._arrays = Numbers[bytes]()
        self._numbers: dict[bytes, int] = {}
        self._count = 0

    def __len__(self) -> int:
        return len(self._kept)

    def add(self, thing: T) -> int:
        """The number of its content."""
        stream, buffers = _Pickler(self._table).pickled(thing)
        numbers = tuple(map(self._arrays.add, buffers))
        digest = _digest(stream, numbers)
        number = self._numbers.setdefault(digest, self._count)
        if number == self._count:
            self._count += 1
            self._kept[number] = _Kept(digest, stream, numbers)
        return number

    def load(self, number: int) -> T:
        """A copy of the object, for the caller to change."""
        kept = self._kept[number]
        arrays = map(self._arrays.__getitem__, kept.arrays)
        thing: T = _Unpickler(kept.stream, arrays, self._constants, self._values).load()
        return thing

    def keep_only(self, numbers: Collection[int]) -> None:
        """Forget all others. Their numbers do not come again, so a content may get another one later."""
        self._kept = {number: self._kept[number] for number in numbers}
        self._numbers = {kept.digest: number for number, kept in self._kept.items()}
        self._arrays.keep_only({array for kept in self._kept.values() for array in kept.arrays})

    def _constant(self, thing: object) -> str | tuple[Any, ...]:
        """How an object of a constant's type is written."""
        number = 0 if isinstance(thing, np.random.Generator) else self._by_id.get(id(thing))
        return thing.__reduce_ex__(5) if number is None else (_constant, (number,))

    def _fixed(self, thing: object) -> tuple[Any, ...]:
        number = self._by_id.get(id(thing))
        if number is None:
            number = self._fixed_numbers.setdefault(pickle.dumps(thing), len(self._constants))
            if number == len(self._constants):
                self._constants.append(thing)
            self._by_id[id(thing)] = number
            self._alive.append(thing)
        return _constant, (number,)

    def _value(self, value: Hashable) -> tuple[Any, ...]:
        return _value, (self._values.add(value),)


def _digest(stream: bytes, arrays: tuple[int, ...]) -> bytes:
    return blake2b(stream + repr(arrays).encode(), digest_size=_DIGEST_BYTES).digest()
