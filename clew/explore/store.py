"""Keeps objects as numbers, so that states can be compared and merged.

Rule 1: a number stands for the whole content: contents with the same number are equal in every value. Equal
        contents may have two numbers where values are one object in one and two in the other: 1 in 2,000.
Rule 2: `load` returns an object that its caller may change.
Rule 3: constants are shared, not copied: objects that nothing changes, or whose changes have no effect.
        Random streams are such, since what is explored has no noise.
Rule 4: inside an object, values that have numbers of their own are written as those.
"""

import io
import pickle
from collections import OrderedDict
from collections.abc import Hashable, Iterable, Sequence
from functools import cache
from hashlib import blake2b
from importlib import import_module
from typing import Any, Generic, TypeVar

import numpy as np

T = TypeVar("T")
H = TypeVar("H", bound=Hashable)

AT_HAND_MAX = 2000  # objects that are kept as such, about 30 kB each: most are needed once more, soon
APART_BYTES = 2048  # arrays from this size on are kept apart: maps of guidance, equal in most snapshots
_DIGEST_BYTES = 16  # 2**64 contents until one pair is likely to be confused


class Numbers(Generic[H]):
    """Values that do not change, such as messages: each once."""

    def __init__(self) -> None:
        self._kept: list[H] = []
        self._numbers: dict[H, int] = {}
        self._by_id: dict[int, int] = {}  # faster than to compare; what is kept stays alive

    def __len__(self) -> int:
        return len(self._kept)

    def __getitem__(self, number: int) -> H:
        return self._kept[number]

    def add(self, value: H) -> int:
        """The number of the value."""
        number = self._by_id.get(id(value))
        if number is not None:
            return number
        number = self._numbers.setdefault(value, len(self._kept))
        if number == len(self._kept):
            self._kept.append(value)
            self._by_id[id(value)] = number
        return number


class _Pickler(pickle.Pickler):
    """Calls no method of ours for most objects, which would take most of the time."""

    def __init__(self, table: dict[type, Any]) -> None:
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
        return self._own[name] if module == __name__ else _found(module, name)


@cache
def _found(module: str, name: str) -> object:
    found: object = import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    return found


class Snapshots(Generic[T]):
    """Objects that change, such as cores: each content once."""

    def __init__(
        self, constants: Sequence[object], values: Numbers[Any], value_types: Iterable[type] = ()
    ) -> None:
        """The values of these types inside an object are kept by `values` (rule 4)."""
        self._constants = [*constants, np.random.default_rng(0)]
        self._values = values
        self._by_id = {id(constant): number for number, constant in enumerate(constants)}
        self._table: dict[type, Any] = dict.fromkeys(map(type, self._constants), self._constant)
        self._table |= dict.fromkeys(value_types, self._value)
        self._kept: list[tuple[bytes, tuple[int, ...]]] = []
        self._arrays = Numbers[bytes]()
        self._numbers: dict[bytes, int] = {}
        self._at_hand: OrderedDict[int, T] = OrderedDict()

    def __len__(self) -> int:
        return len(self._kept)

    def add(self, thing: T) -> int:
        """The number of its content. The caller changes it no more."""
        stream, buffers = _Pickler(self._table).pickled(thing)
        arrays = tuple(map(self._arrays.add, buffers))
        number = self._numbers.setdefault(_digest(stream, arrays), len(self._kept))
        if number == len(self._kept):
            self._kept.append((stream, arrays))
            self._at_hand[number] = thing
            if len(self._at_hand) > AT_HAND_MAX:
                self._at_hand.popitem(last=False)
        return number

    def load(self, number: int) -> T:
        """The object, or a copy of it, for the caller to change."""
        thing = self._at_hand.pop(number, None)
        if thing is None:
            stream, arrays = self._kept[number]
            buffers = [self._arrays[each] for each in arrays]
            thing = _Unpickler(stream, buffers, self._constants, self._values).load()
        return thing

    def _constant(self, thing: object) -> str | tuple[Any, ...]:
        """How an object of a constant's type is written."""
        number = self._by_id.get(id(thing))
        if isinstance(thing, np.random.Generator):
            number = len(self._constants) - 1
        return thing.__reduce_ex__(5) if number is None else (_constant, (number,))

    def _value(self, value: Hashable) -> tuple[Any, ...]:
        return _value, (self._values.add(value),)


def _digest(stream: bytes, arrays: tuple[int, ...]) -> bytes:
    return blake2b(stream + repr(arrays).encode(), digest_size=_DIGEST_BYTES).digest()
