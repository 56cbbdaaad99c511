"""Reads a file into checked types. An error becomes one line that names file, path, bound and value."""

from pathlib import Path
from typing import Any, TypeVar

import msgspec

from protocol.errors import UsageError
from protocol.files.refusals import one_line, short

T = TypeVar("T")


def read(path: Path, source: str) -> dict[str, Any]:
    """The content of a TOML or JSON file, unchecked; `source` names it in error messages."""
    try:
        text = path.read_bytes()
        said = msgspec.toml.decode(text) if path.suffix == ".toml" else msgspec.json.decode(text)
    except OSError as error:
        raise UsageError(f"{source}: cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise UsageError(f"{source}: is not {path.suffix[1:].upper()}: {error}") from error
    if not isinstance(said, dict):
        raise UsageError(f"{source}: $: must be an object, got {short(said)}")
    return said


def understand(raw: object, wanted: type[T], source: str) -> T:
    """The raw value as the wanted type; `source` names it in error messages."""
    try:
        return msgspec.convert(raw, wanted)
    except msgspec.ValidationError as error:
        raise UsageError(f"{source}: {one_line(str(error), raw, wanted)}") from error
