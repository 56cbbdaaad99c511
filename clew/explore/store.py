"""Keeps objects as numbers: equal contents have equal numbers, so that states can be compared and merged.

Rule 1: a number stands for the whole content: two contents are told apart unless all values in them are equal.
        Which values are one object in memory does not matter, since cores do not change that on their way.
Rule 2: `load` returns a new object, which its caller may change.
Rule 3: constants are shared, not copied: objects that nothing changes, or whose changes have no effect.
        Random streams are such, since what is explored has no noise.
"""

import io
import pickle
from collections.abc import Hashable, Sequence
from hashlib import blake2b
from typing import Generic, TypeVar

import numpy as np

T = TypeVar("T")
H = TypeVar("H", bound=Hashable)

_CHANCE = -1  # in place of any random stream
_DIGEST_BYTES = 16  # 2**64 contents until one pair is likely to be confused


class _Pickler(pickle.Pickler):
    def __init__(self, constants: dict[int, int], *, fast: bool) -> None:
        self._file, self._buffers = io.BytesIO(), list[pickle.PickleBuffer]()
        super().__init__(self._file, protocol=5, buffer_callback=self._buffers.append)
        self.fast = fast  # writes a shared object again, so that sharing does not show
        self._constants = constants

    def persistent_id(self, obj: object) -> int | None:
        return _CHANCE if isinstance(obj, np.random.Generator) else self._constants.get(id(obj))

    def pickled(self, thing: object) -> tuple[bytes, tuple[bytes, ...]]:
        self.dump(thing)
        return self._file.getvalue(), tuple(buffer.raw().tobytes() for buffer in self._buffers)


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: bytes, buffers: Sequence[bytes], constants: Sequence[object]) -> None:
        super().__init__(io.BytesIO(stream), buffers=map(bytearray, buffers))
        self._constants = constants

    def persistent_load(self, number: int) -> object:
        return np.random.default_rng(0) if number == _CHANCE else self._constants[number]


class Snapshots(Generic[T]):
    """Objects that change, such as cores: each content once."""

    def __init__(self, constants: Sequence[object]) -> None:
        self._constants = constants
        self._by_id = {id(constant): number for number, constant in enumerate(constants)}
        self._kept: list[tuple[bytes, tuple[int, ...]]] = []
        self._arrays = Numbers[bytes]()  # maps of guidance: large, and equal in most snapshots
        self._by_stream: dict[bytes, int] = {}
        self._by_content: dict[bytes, int] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def add(self, thing: T) -> int:
        """The number of its content."""
        stream, arrays = self._pickled(thing, fast=False)
        key = _digest(stream, arrays)
        if (known := self._by_stream.get(key)) is not None:
            return known
        content = _digest(*self._pickled(thing, fast=True))
        number = self._by_content.setdefault(content, len(self._kept))
        if number == len(self._kept):
            self._kept.append((stream, arrays))
        self._by_stream[key] = number
        return number

    def load(self, number: int) -> T:
        """A copy of the object."""
        stream, arrays = self._kept[number]
        thing: T = _Unpickler(stream, [self._arrays[each] for each in arrays], self._constants).load()
        return thing

    def _pickled(self, thing: T, *, fast: bool) -> tuple[bytes, tuple[int, ...]]:
        stream, arrays = _Pickler(self._by_id, fast=fast).pickled(thing)
        return stream, tuple(map(self._arrays.add, arrays))


class Numbers(Generic[H]):
    """Values that do not change, such as messages: each once."""

    def __init__(self) -> None:
        self._kept: list[H] = []
        self._numbers: dict[H, int] = {}

    def __len__(self) -> int:
        return len(self._kept)

    def __getitem__(self, number: int) -> H:
        return self._kept[number]

    def add(self, value: H) -> int:
        """The number of the value."""
        number = self._numbers.setdefault(value, len(self._kept))
        if number == len(self._kept):
            self._kept.append(value)
        return number


def _digest(stream: bytes, arrays: tuple[int, ...]) -> bytes:
    return blake2b(stream + repr(arrays).encode(), digest_size=_DIGEST_BYTES).digest()
