"""Reads a file into checked types. An error becomes one line that names file, path, bound and value.

Rule 1: a file has a bounded size and depth, and its integers have 64 bits: an error message can show no more.
"""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from protocol.errors import UsageError
from protocol.files.opening import WRITTEN_BYTES_MAX, read_bytes
from protocol.files.refusals import one_line, short

T = TypeVar("T")

DEPTH_MAX = 64  # of nested tables and lists; scenarios have 4
INTEGER_MAX = 2**64
_TOO_DEEP = f"it is nested deeper than {DEPTH_MAX}"
_LONG_KEY = re.compile(
    rb"(?<![\w\"'-])(?:(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+\.[ \t]*+){%d}" % DEPTH_MAX
)


def read(path: Path, source: str) -> dict[str, Any]:
    """The content of a TOML or JSON file, unchecked; `source` names it in error messages."""
    try:
        said = decode(read_bytes(path, WRITTEN_BYTES_MAX), path.suffix)
    except OSError as error:
        raise UsageError(f"{source}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise UsageError(f"{source}: is not {path.suffix[1:].upper()}: {error}") from error
    if not isinstance(said, dict):
        raise UsageError(f"{source}: $: must be an object, got {short(said)}")
    return said


def decode(text: bytes, suffix: str) -> object:
    """Decode TOML or JSON.

    Raises:
        ValueError: the text is invalid or violates rule 1.
    """
    if suffix == ".toml" and _LONG_KEY.search(text):  # its memory use would be quadratic
        raise ValueError(f"a key has more than {DEPTH_MAX} parts")
    if suffix != ".toml" and not text.strip():  # what `clew map ... > FILE.json` leaves when it refuses
        raise ValueError("it is empty")
    try:
        said: object = msgspec.toml.decode(text) if suffix == ".toml" else msgspec.json.decode(text)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
    _check(said)
    return said


def _check(said: object) -> None:
    """Rule 1, level by level."""
    level = [said]
    for _ in range(DEPTH_MAX + 1):
        for value in level:
            if isinstance(value, int) and abs(value) > INTEGER_MAX:
                raise ValueError("an integer has more than 64 bits")
        inner = [value.values() if isinstance(value, dict) else value for value in level]
        level = [
            each
            for value in inner
            if not isinstance(value, str) and isinstance(value, Iterable)
            for each in value
        ]
        if not level:
            return
    raise ValueError(_TOO_DEEP)


def understand(raw: object, wanted: type[T], source: str) -> T:
    """The raw value as the wanted type; `source` names it in error messages."""
    try:
        return msgspec.convert(raw, wanted)
    except msgspec.ValidationError as error:
        raise UsageError(f"{source}: {one_line(str(error), raw, wanted)}") from error
